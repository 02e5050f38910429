//! Whole prove-outs of the scenes, at coarse cells where the judged quantity does not depend on them.

mod axis_cross;
mod cone_frustum;
