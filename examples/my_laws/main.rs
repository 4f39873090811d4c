//! The program `nonsmooth` with a law of one's own: in scene files, in studies and under `nonsmooth laws`.
//!
//! ```text
//! cargo run --release --example my_laws -- laws
//! cargo run --release --example my_laws -- run examples/my_laws/ball.toml
//! cargo run --release --example my_laws -- study examples/my_laws/study.toml
//! ```
//!
//! The law is the file `speed_dependent.rs`; `tests/my_laws.rs` puts it under the property suite of the built-in laws.

mod speed_dependent;

use std::process::ExitCode;

use nonsmooth::{cli, laws, registry::RegistryError};

fn main() -> Result<ExitCode, RegistryError> {
    Ok(cli::run(&nonsmooth::registry().law(laws::family!(speed_dependent::SpeedDependent<T>))?))
}
