#![allow(dead_code, missing_docs, clippy::all)]
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
pub(crate) static C: [AtomicU64; 16] = [const { AtomicU64::new(0) }; 16];
pub(crate) fn add(i: usize, n: u64) { C[i].fetch_add(n, Relaxed); }
pub(crate) fn show(what: &str) {
    let v: Vec<u64> = C.iter().map(|c| c.swap(0, Relaxed)).collect();
    eprintln!("{what}: solves {} good {} kept-bad {}, part-solves {} fails {}, iters {}, node-iters {}, rowpair-iters {}, single inserts {}, tighten {}, repairs {} second {}, splits {}, dips {}, levels {}", v[0],v[1],v[2],v[3],v[4],v[5],v[6],v[7],v[8],v[9],v[10],v[11],v[12],v[13],v[14]);
}
