//! Sweeps: one scene run many times, with other values of its inputs, by as many processes and
//! machines as there are.
//!
//! ```text
//!   sweep.toml ── plan ──► OUT/plan.json                  digests of all jobs, in order
//!                          OUT/jobs/00000/job.json        values, inputs with SHA-256, digest of both
//!                                                         and of the version
//!                 run  ──► OUT/jobs/00000/result.json     verdict and figures under the digest of the
//!                                                         job; written at once, last
//!                          OUT/jobs/00000/verdict.json    or run/, the whole run folder
//!                 merge ─► OUT/sweep.parquet, .csv, .html, .json
//! ```
//!
//! Jobs know nothing of each other and nothing of who starts them: a job whose result has its digest is done,
//! any other is not. So a second run starts nothing, a worker that was killed costs its job, and a changed
//! input costs the jobs that read it. `run` and `merge` hold plan, jobs, inputs and verdicts against their
//! digests again, also for jobs whose results are there. Results depend on the job alone, and are merged in
//! order: same plan, same bytes, whoever ran what.
//!
//! *Digest of a job*: SHA-256 of version, program, values and inputs, as in `job.json`.
//!
//! *Designs.* `grid`: all combinations, the last key changing fastest. `list`: the first values of all keys,
//! then the second ones. `latin-hypercube`: n draws, of which each key has one in every n-th part of its
//! range (`McKay`, Beckman, Conover 1979); the order comes from the `seed`.
//!
//! A single run in `shards` has a job for each: [`crate::run::shards`].

mod design;
mod file;
mod plan;
mod result;

pub use design::Design;
pub use file::{DesignFile, KeepFile, Sweep, SweepFile, VaryFile};
pub use plan::{JOB, JOBS, PLAN, Plan, PlanReport, Planned, Recheck, check_shard, job_folder, plan, prepare_job};
pub use result::{
    Figures, JobResult, JobState, RESULT, ResultFault, check_verdict, read_result, result_of, result_of_shard,
    write_result,
};
