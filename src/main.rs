//! The command line of `nonsmooth`.

use nonsmooth::{cli, registry};

fn main() -> std::process::ExitCode {
    cli::run(&registry())
}
