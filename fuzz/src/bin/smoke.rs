//! Runs the fuzz bodies without a fuzzer, on pseudo-random bytes with a fixed seed, for a number of seconds each. For machines without a nightly compiler.
//!
//! `smoke [--seconds S] [--only BODY] [FILE...]`: with files, each is run once instead, to reproduce a finding of libFuzzer.

use std::panic::catch_unwind;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use sinew_fuzz::BODIES;

/// xorshift64*: it needs no crate, and the fixed seed makes findings reproducible.
struct Xorshift(u64);

impl Xorshift {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    /// Up to 2047 bytes, with short and long inputs about equally frequent.
    fn bytes(&mut self, bytes: &mut Vec<u8>) {
        let most = 1 << (self.next() % 12);
        let len = self.next() % most;
        bytes.clear();
        bytes.extend((0..len).map(|_| (self.next() >> 32) as u8));
    }
}

fn main() -> ExitCode {
    let (mut seconds, mut only, mut files) = (5.0, None, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--seconds" => {
                seconds = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(seconds);
            }
            "--only" => only = arguments.next(),
            _ => files.push(argument),
        }
    }
    let chosen = BODIES.into_iter().filter(|(name, _)| only.as_deref().is_none_or(|o| o == *name));
    for (name, body) in chosen {
        if files.is_empty() {
            let (mut random, mut bytes, mut runs) = (Xorshift(0x5153_4e45), Vec::new(), 0_u64);
            let end = Instant::now() + Duration::from_secs_f64(seconds);
            while Instant::now() < end {
                random.bytes(&mut bytes);
                if catch_unwind(|| body(&bytes)).is_err() {
                    return found(name, &bytes);
                }
                runs += 1;
            }
            println!("{name}: {runs} runs, nothing found");
        }
        for file in &files {
            match std::fs::read(file) {
                Ok(bytes) => body(&bytes),
                Err(error) => eprintln!("{file}: {error}"),
            }
        }
    }
    ExitCode::SUCCESS
}

/// Saves the input that caused a failure, and prints how to reproduce it.
fn found(name: &str, bytes: &[u8]) -> ExitCode {
    let path = std::env::temp_dir().join(format!("sinew-smoke-{name}"));
    match std::fs::write(&path, bytes) {
        Ok(()) => eprintln!("{name}: found something; run again with: --only {name} {path:?}"),
        Err(error) => eprintln!("{name}: found something in {bytes:?} ({error})"),
    }
    ExitCode::FAILURE
}
