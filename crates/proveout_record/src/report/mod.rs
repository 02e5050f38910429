//! The page `report.html`.

pub(crate) mod data;
pub(crate) mod findings;
pub(crate) mod format;
pub(crate) mod page;
pub(crate) mod plot;

#[cfg(test)]
mod tests;
