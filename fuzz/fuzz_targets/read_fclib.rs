//! Any bytes are a problem or an error: no panic, no allocation beyond what the size of the file allows.
//!
//! ```text
//! cargo install cargo-fuzz
//! mkdir -p fuzz/corpus/read_fclib && cp tests/data/*.hdf5 fuzz/corpus/read_fclib
//! cargo +nightly fuzz run read_fclib -- -max_len=65536 -malloc_limit_mb=64 -timeout=10
//! ```
#![no_main]

use libfuzzer_sys::fuzz_target;
use nonsmooth::fclib::{WriteOptions, read_bytes, write_bytes};

fuzz_target!(|bytes: &[u8]| {
    let Ok(problem) = read_bytes(bytes.to_vec()) else { return };
    // The cone problem may be refused, never with a panic.
    let _ = problem.cone();
    let written = write_bytes(&problem, WriteOptions { gzip: None }).expect("what was read can be written");
    assert_eq!(read_bytes(written).expect("what was written can be read"), problem);
});
