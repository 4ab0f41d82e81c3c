//! Each kernel by itself, through the public API: `cargo bench -p sinew_bench`. The result is the rate of items a second.

use divan::Bencher;
use divan::counter::ItemsCount;
use sinew_bench::kernels::{KERNELS, Kernel, Work};
use sinew_bench::measure::TICK;

fn main() {
    divan::main();
}

/// One step of a simulation whose work is this kernel.
#[divan::bench(args = KERNELS, sample_count = 20)]
fn kernel(bencher: Bencher, kernel: &Kernel) {
    let Work { mut world, count } = kernel.work();
    // The first step builds the solver's plan, which is not timed.
    let _ = world.step(TICK);
    bencher.counter(ItemsCount::new(count)).bench_local(|| world.step(TICK).is_ok());
}
