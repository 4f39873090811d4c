//! The command line of `nonsmooth`.

use nonsmooth::{cli, registry::Registry};

fn main() -> std::process::ExitCode {
    cli::run(&Registry::default())
}
