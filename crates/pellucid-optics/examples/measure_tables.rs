//! Measures the tables: how long they take to build, how far they are from the exact curves and
//! what a look-up costs. Run with `cargo run --release -p pellucid-optics --example measure_tables`.

use std::hint::black_box;
use std::time::Instant;

use pellucid_optics::{
    Color, ColorPoint, DataRange, OpacityPoint, OpticsError, PreIntegration, StepTable, Table, TransferFunction,
};

/// A grey ramp with a triangular peak of opacity, `width` wide at its base.
fn peak(width: f64) -> Result<TransferFunction, OpticsError> {
    let colors = vec![ColorPoint::new(0.0, Color::BLACK), ColorPoint::new(1.0, Color::WHITE)];
    let points = [(0.0, 0.0), (0.4, 0.0), (0.4 + width / 2.0, 0.8), (0.4 + width, 0.0), (1.0, 0.1)];
    TransferFunction::new(colors, points.map(|(value, opacity)| OpacityPoint::new(value, opacity)).to_vec())
}

fn milliseconds<T>(work: impl Fn() -> T) -> f64 {
    black_box(work());
    let start = Instant::now();
    const RUNS: u32 = 5;
    for _ in 0..RUNS {
        black_box(work());
    }
    start.elapsed().as_secs_f64() * 1e3 / RUNS as f64
}

fn main() -> Result<(), OpticsError> {
    println!("error of tables of float data, and the size chosen for it");
    for width in [0.5, 0.1, 0.02, 0.005] {
        let tf = peak(width)?;
        print!("  peak of {:>4.1} %:", width * 100.0);
        for size in [256, 1024, 4096, 16_384, 65_536] {
            let table = Table::build(&tf, [0.0, 1.0], size)?;
            let exact = |i: u32| i as f64 / 1e6;
            let error = (0..1_000_000).map(|i| (table.lookup(exact(i) as f32)[3] - tf.opacity(exact(i))).abs());
            print!("  {size}: {:.5}", error.fold(0.0, f32::max));
        }
        let chosen = Table::for_data(&tf, &DataRange { low: 0.0, high: 1.0, level_spacing: None })?;
        println!("  chosen {}", chosen.nodes().count());
    }
    let tf = peak(0.02)?;
    println!("look-ups of random values, one thread, and of values near each other");
    for size in [256, 4096, 16_384, 65_536] {
        let table = StepTable::new(&Table::build(&tf, [0.0, 1.0], size)?, 0.5)?;
        let random: Vec<f32> =
            (0..1u32 << 20).map(|i| (i.wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32).collect();
        // A value that drifts as along a ray: a thousandth of the domain per sample.
        let coherent: Vec<f32> = (0..1 << 20).map(|i| 0.5 + 0.5 * (i as f32 * 0.003).sin()).collect();
        let time = |values: &[f32]| {
            let sum = || values.iter().map(|&value| table.lookup(value)[3]).sum::<f32>();
            milliseconds(sum) * 1e6 / values.len() as f64
        };
        println!("  {size}: {:.2} ns, {:.2} ns", time(&random), time(&coherent));
    }
    println!("build, {} threads", rayon::current_num_threads());
    for size in [256, 4096, 65_536] {
        println!("  table of {size}: {:.2} ms", milliseconds(|| Table::build(&tf, [0.0, 1.0], size)));
    }
    for size in [256, 512, 1024] {
        let full = milliseconds(|| PreIntegration::build(&tf, [0.0, 1.0], size, 1.0));
        let fast = milliseconds(|| PreIntegration::fast(&tf, [0.0, 1.0], size, 1.0));
        println!("  pre-integration of {size}: {full:.1} ms, fast {fast:.1} ms");
    }
    Ok(())
}
