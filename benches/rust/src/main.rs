//! Times the Rust calls: `telespring-bench DIRECTORY [--quick]` writes `timings.json` and the
//! simulated positions (`*.f64`, little-endian, robot 1 then robot 2) into the directory.

mod criteria;
mod peer;
mod roots;
mod session;
mod simulation;
mod stability_map;
mod timing;

use std::error::Error;
use std::path::PathBuf;

use serde_json::{Map, Value};

/// Where the results go, and how much work to do.
struct Bench {
    directory: PathBuf,
    /// Small sizes and few repetitions: only that everything runs.
    quick: bool,
    results: Map<String, Value>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let directory = PathBuf::from(arguments.next().ok_or("usage: telespring-bench DIRECTORY [--quick]")?);
    let quick = match arguments.next().as_deref() {
        None => false,
        Some("--quick") => true,
        Some(other) => return Err(format!("unknown argument {other}").into()),
    };
    let mut bench = Bench { directory, quick, results: Map::new() };
    simulation::run(&mut bench)?;
    peer::run(&mut bench)?;
    roots::run(&mut bench)?;
    criteria::run(&mut bench)?;
    stability_map::run(&mut bench)?;
    session::run(&mut bench)?;
    let text = serde_json::to_string_pretty(&Value::Object(bench.results))?;
    std::fs::write(bench.directory.join("timings.json"), text)?;
    Ok(())
}

impl Bench {
    fn save(&self, name: &str, robots: [&[f64]; 2]) -> std::io::Result<()> {
        let bytes: Vec<u8> = robots.into_iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(self.directory.join(name).with_extension("f64"), bytes)
    }
}
