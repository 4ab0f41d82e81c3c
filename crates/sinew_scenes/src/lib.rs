//! Named scenes that the examples, tests and benchmarks share.
