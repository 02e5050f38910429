//! The tool assembly as pictures, one a role.

use proveout_tool::{Role, Tool};

use crate::{color::Rgba, in_process::CREASE, picture::Picture};

fn role_color(role: Role) -> Rgba {
    match role {
        Role::Cutting => [214, 168, 60, 255],
        Role::Neck => [176, 150, 110, 255],
        Role::Shank => [170, 176, 184, 255],
        Role::Holder => [88, 94, 104, 255],
    }
}

const ROLES: [(Role, &str); 4] =
    [(Role::Cutting, "cutting"), (Role::Neck, "neck"), (Role::Shank, "shank"), (Role::Holder, "holder")];

/// Name, color and picture of each role in the tip frame T; without triangles where the tool has no such
/// part.
pub(crate) fn tool_pictures(tool: Option<&Tool>) -> Vec<(&'static str, Rgba, Picture)> {
    let picture = |(role, name): (Role, &'static str)| {
        let mut picture = Picture::default();
        for body in tool.iter().flat_map(|t| &t.bodies).filter(|b| b.role == role) {
            let chord = (0.01 * body.profile.max_radius()).clamp(0.005, 0.2);
            let mesh = proveout_geom::revolved_mesh(&body.profile.polyline(chord), 48);
            picture.append(&Picture::creased(&mesh, CREASE));
        }
        (name, role_color(role), picture)
    };
    ROLES.map(picture).into()
}
