//! `pellucid schema`.

use pellucid::scene::json_schema;

use super::failure::Failure;
use super::report::print;

pub fn run() -> Result<(), Failure> {
    print(&json_schema())
}
