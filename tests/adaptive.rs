//! Steps under error control.
#![cfg(feature = "scene")]

#[path = "mechanics/event_driven.rs"]
mod event_driven;
#[path = "mechanics/example.rs"]
mod example;
#[path = "mechanics/impact.rs"]
mod impact;
mod motions;

use motions::{cases, run};

const TOLERANCES: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

#[test]
fn explore() {
    let all = cases(&["newton", "fremond"]);
    let only = std::env::var("ONLY").unwrap_or_default();
    for case in all.frictionless.iter().filter(|c| c.name.contains(&only)) {
        for e in TOLERANCES {
            if std::env::var("EPS").is_ok_and(|x| x.parse::<f64>().unwrap() != e) {
                continue;
            }
            let mut n = 0;
            match run::<1>(case, e, |s, st| {
                n += 1;
                if std::env::var("TRACE").is_ok_and(|x| case.name.starts_with(&x)) && n < 400 {
                    println!(
                        "{} t {:.12} {} q {:?} v {:?} p {:?}",
                        n,
                        s.time,
                        0,
                        s.q.get(1),
                        s.v.get(1),
                        st.contacts.first().map(|c| c.percussion[0])
                    );
                }
            }) {
                Ok((errors, r)) => println!(
                    "{:28} {e:e}: q {:.2e} v {:.2e} err/eps {:.3} est/eps {:.2} acc {} rej {} comp {} ev {} h {:.1e} {:.1e}",
                    case.name,
                    errors.q,
                    errors.v,
                    errors.largest() / e,
                    r.estimated_error / e,
                    r.accepted,
                    r.rejected,
                    r.computed,
                    r.events,
                    r.smallest_step,
                    r.largest_step
                ),
                Err(x) => println!("{:28} {e:e}: {x}", case.name),
            }
        }
    }
    for case in all.frictional.iter().filter(|c| c.name.contains(&only)) {
        for e in TOLERANCES {
            if std::env::var("EPS").is_ok_and(|x| x.parse::<f64>().unwrap() != e) {
                continue;
            }
            match {
                let mut n = 0;
                run::<2>(case, e, |s, st| {
                    n += 1;
                    if std::env::var("TRACE").is_ok_and(|x| case.name.starts_with(&x)) {
                        println!(
                            "{} t {:.12} q {:?} v {:?} p {:?} {:?}",
                            n,
                            s.time,
                            s.q,
                            s.v,
                            st.contacts.first().map(|c| (c.percussion, c.before, c.after)),
                            st.contacts.len()
                        );
                    }
                })
            } {
                Ok((errors, r)) => println!(
                    "{:28} {e:e}: q {:.2e} v {:.2e} err/eps {:.3} est/eps {:.2} acc {} rej {} comp {} ev {} h {:.1e} {:.1e}",
                    case.name,
                    errors.q,
                    errors.v,
                    errors.largest() / e,
                    r.estimated_error / e,
                    r.accepted,
                    r.rejected,
                    r.computed,
                    r.events,
                    r.smallest_step,
                    r.largest_step
                ),
                Err(x) => println!("{:28} {e:e}: {x}", case.name),
            }
        }
    }
}
