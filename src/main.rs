//! The command line of `nonsmooth`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
