//! Damaged and lying FCLIB files: each is refused with the reason, none panics.
#![cfg(feature = "fclib")]

use hdf5_pure::{FileBuilder, GroupBuilder};
use nonsmooth::cone::ProblemError;
use nonsmooth::fclib::{
    self, Data, FclibError, Global, Info, Local, Problem, Solution, SparseMatrix, WriteOptions,
};

/// A matrix as a file may declare it, right or wrong.
#[derive(Clone)]
struct Raw {
    m: i32,
    n: i32,
    nz: i32,
    nzmax: i32,
    p: Vec<i32>,
    i: Vec<i32>,
    x: Vec<f64>,
}

/// A planar local problem of two contacts as a file may declare it.
#[derive(Clone)]
struct Lie {
    w: Raw,
    q: Vec<f64>,
    mu: Vec<f64>,
    spacedim: i32,
}

/// The identity in compressed rows: an honest file.
fn honest() -> Lie {
    let w = Raw { m: 4, n: 4, nz: -2, nzmax: 4, p: (0..5).collect(), i: (0..4).collect(), x: vec![1.0; 4] };
    Lie { w, q: vec![-1.0; 4], mu: vec![0.5; 2], spacedim: 2 }
}

fn put(root: &mut GroupBuilder, name: &str, matrix: &Raw) {
    let mut group = root.create_group(name);
    let sizes = [("m", matrix.m), ("n", matrix.n), ("nz", matrix.nz), ("nzmax", matrix.nzmax)];
    for (name, value) in sizes {
        group.create_dataset(name).with_i32_data(&[value]);
    }
    group.create_dataset("p").with_i32_data(&matrix.p);
    group.create_dataset("i").with_i32_data(&matrix.i);
    group.create_dataset("x").with_f64_data(&matrix.x);
    root.add_group(group.finish());
}

fn file(lie: &Lie, more: impl FnOnce(&mut FileBuilder)) -> Vec<u8> {
    let mut file = FileBuilder::new();
    let mut root = file.create_group("fclib_local");
    root.create_dataset("spacedim").with_i32_data(&[lie.spacedim]);
    put(&mut root, "W", &lie.w);
    let mut vectors = root.create_group("vectors");
    vectors.create_dataset("q").with_f64_data(&lie.q);
    vectors.create_dataset("mu").with_f64_data(&lie.mu);
    root.add_group(vectors.finish());
    file.add_group(root.finish());
    more(&mut file);
    file.finish().expect("a file of our own")
}

/// The error of the honest file after one change.
fn refusal(change: impl FnOnce(&mut Lie)) -> FclibError {
    let mut lie = honest();
    change(&mut lie);
    let read = fclib::read_bytes(file(&lie, |_| {}));
    read.and_then(|problem| problem.cone()).expect_err("a lie")
}

#[test]
fn the_honest_file_is_read() {
    let problem = fclib::read_bytes(file(&honest(), |_| {})).expect("an honest file");
    assert_eq!(problem.cone().expect("a cone problem").contacts(), 2);
}

#[test]
fn sizes_that_contradict_each_other_are_refused() {
    let length = |name: &str, expected: u64, found: u64, error: FclibError| {
        let FclibError::Length { dataset, expected: e, found: f } = &error else { panic!("{error}") };
        assert_eq!((dataset.rsplit('/').next(), *e, *f), (Some(name), expected, found), "{error}");
    };
    length("q", 4, 3, refusal(|lie| lie.q.truncate(3)));
    length("mu", 2, 3, refusal(|lie| lie.mu.push(0.1)));
    length("p", 5, 4, refusal(|lie| lie.w.p.truncate(4)));
    length("i", 4, 5, refusal(|lie| lie.w.i.push(0)));
    length("x", 4, 1, refusal(|lie| lie.w.x.truncate(1)));
    length("nzmax", 9, 4, refusal(|lie| lie.w.nz = 9));
    length("x", 5, 4, refusal(|lie| (lie.w.nzmax, lie.w.i) = (5, vec![0, 1, 2, 3, 0])));
    assert!(matches!(refusal(|lie| lie.w.m = 6), FclibError::Shape { rows: 6, columns: 4, .. }));
    assert!(matches!(refusal(|lie| (lie.w.m, lie.w.n) = (5, 5)), FclibError::Shape { rows: 5, .. }));
}

#[test]
fn absurd_counts_are_refused_before_anything_is_allocated() {
    for count in [-1, i32::MIN] {
        assert!(
            matches!(refusal(|lie| lie.w.m = count), FclibError::Count { value, .. } if value == i64::from(count))
        );
        assert!(matches!(refusal(|lie| lie.w.nzmax = count), FclibError::Count { .. }));
    }
    // Two thousand million contacts in a file of a few kilobytes.
    let huge = i32::MAX - 1;
    assert!(matches!(refusal(|lie| (lie.w.m, lie.w.n) = (huge, huge)), FclibError::Length { .. }));
    assert!(matches!(refusal(|lie| lie.w.nzmax = huge), FclibError::Length { .. }));
    assert!(matches!(refusal(|lie| (lie.w.nz, lie.w.nzmax) = (huge, huge)), FclibError::Length { .. }));
    for dimension in [-3, 0, 1, 4, i32::MAX] {
        let error = refusal(|lie| lie.spacedim = dimension);
        assert!(
            matches!(error, FclibError::Dimension { value, .. } if value == i64::from(dimension)),
            "{error}"
        );
    }
    assert!(matches!(refusal(|lie| lie.w.nz = -3), FclibError::Storage { value: -3, .. }));
    let guesses = |file: &mut FileBuilder| {
        let mut group = file.create_group("guesses");
        group.create_dataset("number_of_guesses").with_i32_data(&[i32::MAX]);
        file.add_group(group.finish());
    };
    assert!(matches!(fclib::read_bytes(file(&honest(), guesses)), Err(FclibError::Missing { .. })));
}

#[test]
fn a_bomb_is_refused_by_its_declared_size() {
    // 80 MB of zeros in a hundred kilobytes of gzip, beyond 16 MiB + 128 × size.
    let entries = 10_000_000;
    let mut file = FileBuilder::new();
    let mut root = file.create_group("fclib_local");
    root.create_dataset("spacedim").with_i32_data(&[2]);
    let mut w = root.create_group("W");
    for (name, value) in [("m", 4), ("n", 4), ("nz", entries), ("nzmax", entries)] {
        w.create_dataset(name).with_i32_data(&[value]);
    }
    let zeros = vec![0_i32; entries as usize];
    for name in ["p", "i"] {
        w.create_dataset(name).with_i32_data(&zeros).with_chunks(&[entries as u64]).with_deflate(9);
    }
    root.add_group(w.finish());
    let mut vectors = root.create_group("vectors");
    vectors.create_dataset("q").with_f64_data(&[-1.0; 4]);
    root.add_group(vectors.finish());
    file.add_group(root.finish());
    let bytes = file.finish().expect("a file of our own");
    let allowance = fclib::allowance(bytes.len() as u64);
    assert!(allowance < 8 * entries as u64, "the file is {} bytes", bytes.len());
    let error = fclib::read_bytes(bytes).expect_err("a bomb");
    assert!(matches!(error, FclibError::TooLarge { bytes: 80_000_000, .. }), "{error}");
}

#[test]
fn indices_and_starts_stay_inside_the_matrix() {
    for index in [-1, 4, i32::MAX] {
        let error = refusal(|lie| lie.w.i[2] = index);
        let FclibError::Index { position: 2, value, bound: 4, .. } = error else { panic!("{error}") };
        assert_eq!(value, i64::from(index));
    }
    for (position, value) in [(0, 1), (2, 0), (3, 5), (4, -1)] {
        let error = refusal(|lie| lie.w.p[position] = value);
        let FclibError::Start { position: found, .. } = error else { panic!("{error}") };
        // The start itself is out of order, or it makes the next one so.
        assert!(found == position || found == position + 1);
    }
}

#[test]
fn numbers_that_are_none_are_refused() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let at = |error| match error {
            FclibError::NotFinite { dataset, position } => (dataset, position),
            error => panic!("{error}"),
        };
        assert_eq!(at(refusal(|lie| lie.w.x[3] = bad)), ("fclib_local/W/x".into(), 3));
        assert_eq!(at(refusal(|lie| lie.q[1] = bad)), ("fclib_local/vectors/q".into(), 1));
        assert_eq!(at(refusal(|lie| lie.mu[0] = bad)), ("fclib_local/vectors/mu".into(), 0));
    }
    let error = refusal(|lie| lie.mu[1] = -0.1);
    assert!(matches!(error, FclibError::NegativeFriction { contact: 1, value: -0.1 }), "{error}");
    // An operator that moves nothing is read, and refused as a cone problem.
    let error = refusal(|lie| lie.w.x[2] = 0.0);
    assert!(matches!(error, FclibError::Problem(ProblemError::NoMobility { contact: 1, .. })), "{error}");
}

#[test]
fn what_is_missing_or_of_another_kind_is_named() {
    let bytes = FileBuilder::new().finish().expect("an empty file");
    assert!(matches!(fclib::read_bytes(bytes), Err(FclibError::NotFclib)));
    for bytes in [vec![], b"not HDF5 at all".to_vec(), vec![0; 4096]] {
        assert!(matches!(fclib::read_bytes(bytes), Err(FclibError::Hdf5 { .. })));
    }
    assert!(matches!(fclib::read("/there/is/no/such.hdf5"), Err(FclibError::Io { .. })));

    let mut file = FileBuilder::new();
    let mut root = file.create_group("fclib_local");
    root.create_dataset("spacedim").with_f64_data(&[2.0]);
    file.add_group(root.finish());
    let error = fclib::read_bytes(file.finish().expect("a file of our own")).expect_err("a real spacedim");
    assert!(matches!(error, FclibError::Kind { expected: "integers", .. }), "{error}");

    let mut file = FileBuilder::new();
    let mut root = file.create_group("fclib_local");
    root.create_dataset("spacedim").with_i32_data(&[2]);
    file.add_group(root.finish());
    let error = fclib::read_bytes(file.finish().expect("a file of our own")).expect_err("no W");
    let FclibError::Missing { dataset } = error else { panic!("{error}") };
    assert_eq!(dataset, "fclib_local/W/m");
}

#[test]
fn a_problem_without_contacts_is_a_problem() {
    let none = Raw { m: 0, n: 0, nz: -2, nzmax: 0, p: vec![0], i: vec![], x: vec![] };
    let lie = Lie { w: none, q: vec![], mu: vec![], spacedim: 3 };
    let problem = fclib::read_bytes(file(&lie, |_| {})).expect("nothing is wrong with nothing");
    assert_eq!(problem.cone().expect("a cone problem").contacts(), 0);
    let written = fclib::write_bytes(&problem, WriteOptions::default()).expect("a file");
    assert_eq!(fclib::read_bytes(written).expect("a file of our own"), problem);
}

#[test]
fn the_three_storages_say_the_same_and_repeated_entries_add_up() {
    // [2 0 1 0; 0 2 0 0; 1 0 3 0; 0 0 0 2] with W_22 given as 1 + 2 and rows out of order.
    let rows = Raw {
        m: 4,
        n: 4,
        nz: -2,
        nzmax: 7,
        p: vec![0, 2, 3, 6, 7],
        i: vec![2, 0, 1, 2, 0, 2, 3],
        x: vec![1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 2.0],
    };
    // W is symmetric, so its columns are its rows.
    let columns = Raw { nz: -1, ..rows.clone() };
    // Room for more entries than are used.
    let triplets = Raw {
        nz: 7,
        nzmax: 9,
        i: vec![3, 2, 2, 2, 1, 0, 0, 0, 0],
        p: vec![3, 2, 0, 2, 1, 2, 0, 0, 0],
        x: vec![2.0, 1.0, 1.0, 2.0, 2.0, 1.0, 2.0, 0.0, 0.0],
        ..rows.clone()
    };
    let read = |w: &Raw| fclib::read_bytes(file(&Lie { w: w.clone(), ..honest() }, |_| {})).expect("honest");
    let problem = read(&rows);
    assert_eq!(read(&columns), problem);
    assert_eq!(read(&triplets), problem);
    let Data::Local(Local { delassus, .. }) = &problem.data else { panic!("a local problem") };
    let expected = [(0, 0, 2.0), (0, 2, 1.0), (1, 1, 2.0), (2, 0, 1.0), (2, 2, 3.0), (3, 3, 2.0)];
    assert_eq!(delassus.entries().collect::<Vec<_>>(), expected);

    // An operator that is not symmetric tells rows from columns.
    let upper = Raw { p: vec![0, 2, 3, 4, 5], i: vec![0, 2, 1, 2, 3], x: vec![1.0; 5], nzmax: 5, ..rows };
    let transposed = |raw: &Raw| match read(raw).data {
        Data::Local(local) => local.delassus.entries().filter(|e| e.0 != e.1).collect::<Vec<_>>(),
        Data::Global(_) => unreachable!("a local problem"),
    };
    assert_eq!(transposed(&upper), [(0, 2, 1.0)]);
    assert_eq!(transposed(&Raw { nz: -1, ..upper }), [(2, 0, 1.0)]);
}

#[test]
fn a_mass_that_cannot_be_inverted_is_named() {
    let global = |mass: &[(u32, u32, f64)]| Problem {
        info: Info::default(),
        dimension: 2,
        friction: vec![0.3],
        data: Data::Global(Global {
            mass: SparseMatrix::from_entries(2, 2, mass),
            directions: SparseMatrix::from_entries(2, 2, &[(0, 0, 1.0), (1, 1, 1.0)]),
            force: vec![0.0, -1.0],
            velocity: vec![0.0; 2],
            bilateral: None,
        }),
        guesses: Vec::new(),
        solution: None,
    };
    assert!(global(&[(0, 0, 1.0), (1, 1, 1.0)]).cone().is_ok());
    let singular: [&[(u32, u32, f64)]; 3] =
        [&[], &[(0, 0, 1.0)], &[(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, 1.0)]];
    for mass in singular {
        assert!(matches!(global(mass).cone(), Err(FclibError::Singular { matrix: "M", .. })), "{mass:?}");
    }
}

/// Small files in every shape the reader knows: plain and gzipped, local and global, with guesses and a solution.
fn samples() -> Vec<Vec<u8>> {
    let local = fclib::read_bytes(file(&honest(), |_| {})).expect("an honest file");
    let solution = Solution { percussions: vec![1.0; 4], velocities: vec![0.0; 4], ..Solution::default() };
    let local = Problem {
        info: Info {
            title: Some("two contacts".into()),
            description: Some("a sample".into()),
            math_info: None,
        },
        guesses: vec![solution.clone()],
        solution: Some(solution),
        ..local
    };
    // 600 bodies on a line, so that datasets are long enough to be packed.
    let n = 600_u32;
    let diagonal: Vec<_> = (0..n).map(|i| (i, i, 1.0 + f64::from(i % 7))).collect();
    let directions: Vec<_> = (0..n).map(|i| (i, i, 1.0)).collect();
    let global = Problem {
        info: Info::default(),
        dimension: 3,
        friction: vec![0.3; n as usize / 3],
        data: Data::Global(Global {
            mass: SparseMatrix::from_entries(n as usize, n as usize, &diagonal),
            directions: SparseMatrix::from_entries(n as usize, n as usize, &directions),
            force: vec![-1.0; n as usize],
            velocity: vec![0.0; n as usize],
            bilateral: None,
        }),
        guesses: Vec::new(),
        solution: None,
    };
    let write = |problem, gzip| fclib::write_bytes(problem, WriteOptions { gzip }).expect("a file");
    vec![write(&local, None), write(&global, Some(6)), file(&honest(), |_| {})]
}

/// Reads, condenses, and answers with the number of contacts or an error; a panic fails the test.
fn survive(bytes: Vec<u8>) -> Result<usize, FclibError> {
    fclib::read_bytes(bytes)?.cone().map(|cone| cone.contacts())
}

#[test]
fn truncated_files_are_refused() {
    for sample in samples() {
        assert!(survive(sample.clone()).is_ok());
        // Every length up to 2 kB, then every 37th.
        let lengths = (0..sample.len()).filter(|n| *n < 2048 || n % 37 == 0);
        for length in lengths {
            assert!(survive(sample[..length].to_vec()).is_err(), "{length} of {} bytes", sample.len());
        }
    }
}

#[test]
fn no_damaged_byte_makes_the_reader_panic() {
    let (mut read, mut refused) = (0, 0);
    for sample in samples() {
        for place in 0..sample.len() {
            for change in [|byte: u8| byte ^ 0x81, |_| 0xff_u8] {
                let mut bytes = sample.clone();
                bytes[place] = change(bytes[place]);
                match survive(bytes) {
                    Ok(_) => read += 1,
                    Err(_) => refused += 1,
                }
            }
        }
    }
    println!("{read} damaged files were read all the same, {refused} were refused");
    assert!(read > 0 && refused > 0, "damage that changes nothing, or everything, tests nothing");
}

#[test]
fn no_damaged_stretch_makes_the_reader_panic() {
    // A multiplicative generator (Steele & Vigna 2022, doi:10.1002/spe.3030) with a fixed start.
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |n: usize| {
        state = state.wrapping_mul(0xd134_2543_de82_ef95).wrapping_add(1);
        ((state >> 33) as usize) % n
    };
    for sample in samples() {
        for _ in 0..4000 {
            let mut bytes = sample.clone();
            for _ in 0..1 + below(4) {
                let (place, length) = (below(bytes.len()), 1 + below(8));
                let from = below(bytes.len());
                for k in 0..length.min(bytes.len() - place.max(from)) {
                    bytes[place + k] = bytes[from + k];
                }
            }
            let _ = survive(bytes);
        }
    }
}
