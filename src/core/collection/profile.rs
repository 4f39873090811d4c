//! Performance profiles (Dolan & Moré 2002, doi:10.1007/s101070100263).

/// ρ_s(τ) = share of the problems that solver s solves within τ times the best time of any solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Name of the solver.
    pub solver: String,
    /// τ at which ρ steps up, ascending, each ≥ 1.
    pub ratios: Vec<f64>,
    /// ρ from that τ on; the last one is the share of problems solved at all.
    pub shares: Vec<f64>,
}

/// The profiles of solvers from their times per problem, `None` where one was not solved.
///
/// `times[s][p]` is solver s on problem p. Problems no solver solved stay in the share's denominator.
pub(super) fn profiles(solvers: &[String], times: &[Vec<Option<f64>>]) -> Vec<Profile> {
    let problems = times.first().map_or(0, Vec::len);
    let best: Vec<f64> = (0..problems)
        .map(|p| times.iter().filter_map(|line| line[p]).fold(f64::INFINITY, f64::min))
        .collect();
    let profile = |(solver, line): (&String, &Vec<Option<f64>>)| {
        let mut ratios: Vec<f64> = line
            .iter()
            .zip(&best)
            // Two times below the resolution of the clock are equal.
            .filter_map(|(&time, &best)| time.map(|t| if t > best { t / best } else { 1.0 }))
            .collect();
        ratios.sort_by(f64::total_cmp);
        let shares = (1..=ratios.len()).map(|k| k as f64 / problems as f64).collect();
        Profile { solver: solver.clone(), ratios, shares }
    };
    solvers.iter().zip(times).map(profile).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_starts_at_its_wins_and_each_ends_at_what_it_solves() {
        let names = ["a", "b"].map(String::from);
        let times = [vec![Some(1.0), Some(4.0), None, None], vec![Some(2.0), Some(2.0), Some(5.0), None]];
        let [a, b] = &profiles(&names, &times)[..] else { panic!("two profiles") };
        assert_eq!((&a.ratios[..], &a.shares[..]), (&[1.0, 2.0][..], &[0.25, 0.5][..]));
        assert_eq!((&b.ratios[..], &b.shares[..]), (&[1.0, 1.0, 2.0][..], &[0.25, 0.5, 0.75][..]));
    }

    #[test]
    fn a_time_of_zero_is_the_best_and_divides_nothing() {
        let times = [vec![Some(0.0)], vec![Some(1.0)]];
        let [a, b] = &profiles(&["a", "b"].map(String::from), &times)[..] else { panic!("two profiles") };
        assert_eq!(a.ratios, [1.0]);
        assert_eq!(b.ratios, [f64::INFINITY]);
    }
}
