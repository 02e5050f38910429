//! Observers: Rerun, HTML report, glTF, Parquet, JSON.
