//! The scripts of the pages, joined from small files; each file makes one object with one subject.

/// The part in three dimensions: bytes, vectors, graphics, camera, section, the view itself.
pub(crate) const VIEWER: &str = concat!(
    include_str!("../templates/viewer/bytes.js"),
    include_str!("../templates/viewer/vectors.js"),
    include_str!("../templates/viewer/shaders.js"),
    include_str!("../templates/viewer/graphics.js"),
    include_str!("../templates/viewer/camera.js"),
    include_str!("../templates/viewer/section.js"),
    include_str!("../templates/viewer/view.js"),
);

/// The run over time: motion, bodies, stock, section and measuring, the bar under the view.
pub(crate) const PLAYER: &str = concat!(
    include_str!("../templates/player/motion.js"),
    include_str!("../templates/player/kinematics.js"),
    include_str!("../templates/player/bodies.js"),
    include_str!("../templates/player/stock.js"),
    include_str!("../templates/player/coloring.js"),
    include_str!("../templates/player/measure.js"),
    include_str!("../templates/player/player.js"),
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_end_no_element_and_ask_for_nothing() {
        for script in [VIEWER, PLAYER] {
            for word in ["</script", "<!--", "fetch(", "XMLHttpRequest", "import(", "WebSocket", "eval(", "http"] {
                assert!(!script.contains(word), "{word}");
            }
        }
    }
}
