//! What the text of a STEP file says, counted without its geometry: faces, solids, the unit of length.
//!
//! A kernel that cannot read an entity leaves its face out and says nothing. These counts are what its answer
//! is compared with.

use std::path::Path;

use crate::{
    scan::{Statements, Unended, arguments, instance, records, reference, string},
    step_error::StepError,
    units::{LengthUnit, UnitInstances, is_length, is_of_unit, length_unit},
};

/// What the text of a STEP file says.
#[derive(Clone, Debug, PartialEq)]
pub struct StepText {
    /// Name of its schema, such as `AUTOMOTIVE_DESIGN`.
    pub schema: String,
    /// Faces in the order of the file.
    pub faces: Vec<StepFace>,
    /// Solids in the order of the file; voids belong to them.
    pub solids: Vec<StepFace>,
    /// The unit that its shapes count in.
    pub unit: LengthUnit,
}

/// A face or a solid: an instance with a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StepFace {
    /// Number of the instance.
    pub id: u64,
    /// Its name; often empty.
    pub name: String,
}

impl StepFace {
    /// As messages name it: `#17 "datum face A"`.
    pub(crate) fn shown(&self) -> String {
        if self.name.is_empty() { format!("#{}", self.id) } else { format!("#{} {:?}", self.id, self.name) }
    }
}

/// Keywords of faces, as the kernel reads them.
const FACES: [&[u8]; 2] = [b"ADVANCED_FACE", b"FACE_SURFACE"];
/// Keywords of solids with exact surfaces.
const SOLIDS: [&[u8]; 3] = [b"MANIFOLD_SOLID_BREP", b"BREP_WITH_VOIDS", b"FACETED_BREP"];
/// Keywords of shapes without exact surfaces.
const TESSELLATED: [&[u8]; 2] = [b"TESSELLATED_SOLID", b"TESSELLATED_SHELL"];

impl StepText {
    /// Reads a text; `path` is for messages.
    ///
    /// # Errors
    /// [`StepError::Text`]: no STEP file, a file that ends early, no solid, no unit or two of them.
    pub fn read(path: &Path, text: &[u8]) -> Result<Self, StepError> {
        Reader { path, text }.read()
    }
}

struct Reader<'a> {
    path: &'a Path,
    text: &'a [u8],
}

/// A context of shapes: its number and those of its units.
type Context = (u64, Vec<u64>);

#[derive(Default)]
struct Found<'a> {
    schema: String,
    faces: Vec<StepFace>,
    solids: Vec<StepFace>,
    tessellated: usize,
    contexts: Vec<Context>,
    units: UnitInstances<'a>,
    ended: bool,
}

impl<'a> Reader<'a> {
    fn fault(&self, at: Option<usize>, message: impl Into<String>, help: &str) -> StepError {
        let line = at.map(|at| 1 + self.text.iter().take(at).filter(|b| **b == b'\n').count());
        StepError::Text { path: self.path.into(), line, message: message.into(), help: help.into() }
    }

    fn read(&self) -> Result<StepText, StepError> {
        let again = "export it again";
        let text = self.text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(self.text);
        let offset = self.text.len() - text.len();
        let mut statements = Statements::new(text);
        let mut next = || {
            statements.next().map_err(|Unended(at)| {
                let message = "it ends within a statement that begins here: the file is not whole";
                self.fault(Some(at + offset), message, again)
            })
        };
        if next().ok().flatten().is_none_or(|(_, first)| first != b"ISO-10303-21") {
            let help = "STEP files begin with ISO-10303-21; give one, or a mesh (.stl, .obj, .glb)";
            return Err(self.fault(None, "it is no STEP file", help));
        }
        let mut found = Found::default();
        while let Some((at, statement)) = next()? {
            found.add(statement).map_err(|message| self.fault(Some(at + offset), message, again))?;
            if found.ended {
                return self.whole(found);
            }
        }
        Err(self.fault(None, "it has no END-ISO-10303-21: the file is not whole", again))
    }

    fn whole(&self, found: Found<'_>) -> Result<StepText, StepError> {
        if found.solids.is_empty() {
            let what = match (found.tessellated, found.faces.len()) {
                (0, 0) => "it has no solid and no face".to_owned(),
                (0, n) => format!("it has {n} faces and no solid: surfaces alone enclose nothing"),
                (n, _) => format!("it has {n} bodies of triangles and no solid with exact surfaces"),
            };
            return Err(self.fault(None, what, "export the solid (AP203, AP214 or AP242 with exact geometry)"));
        }
        let unit = self.unit(&found)?;
        Ok(StepText { schema: found.schema, faces: found.faces, solids: found.solids, unit })
    }

    /// The one unit that all contexts count in.
    fn unit(&self, found: &Found<'_>) -> Result<LengthUnit, StepError> {
        let mut units: Vec<(u64, LengthUnit)> = Vec::new();
        for (context, ids) in &found.contexts {
            for id in ids.iter().copied().filter(|id| is_length(&found.units, *id)) {
                let Some(unit) = length_unit(&found.units, id) else {
                    let message = format!("the unit of length #{id} of its context #{context} cannot be understood");
                    return Err(self.fault(None, message, "export it in millimeters or inches"));
                };
                if units.iter().all(|(_, known)| known.millimeters != unit.millimeters) {
                    units.push((*context, unit));
                }
            }
        }
        match units.as_slice() {
            [(_, unit)] => Ok(unit.clone()),
            [] => Err(self.fault(None, "it states no unit of length", "export it in millimeters or inches")),
            [(first, a), (second, b), ..] => {
                let message =
                    format!("it counts in two units: {} (context #{first}) and {} (context #{second})", a.name, b.name);
                Err(self.fault(None, message, "export all parts in one unit, or each part as a file of its own"))
            }
        }
    }
}

impl<'a> Found<'a> {
    /// Adds a statement of the file.
    fn add(&mut self, statement: &'a [u8]) -> Result<(), String> {
        let Some((id, value)) = instance(statement) else {
            if statement == b"END-ISO-10303-21" {
                self.ended = true;
            } else if let [(b"FILE_SCHEMA", names), ..] = records(statement).as_slice() {
                let first = arguments(arguments(names).first().unwrap_or(&b"".as_slice()));
                let name = first.first().and_then(|n| string(n)).unwrap_or_default();
                self.schema = name.split_whitespace().next().unwrap_or_default().to_owned();
            } else if statement.first() == Some(&b'#') {
                return Err("an instance needs a number and a value: #1 = NAME(...)".into());
            }
            return Ok(());
        };
        let word: &[u8] = {
            let length = value.iter().take_while(|b| b.is_ascii_alphanumeric() || **b == b'_').count();
            value.get(..length).unwrap_or_default()
        };
        // Most instances are points, curves and their like: only those that are counted are taken apart.
        if FACES.contains(&word) || SOLIDS.contains(&word) {
            let records = records(value);
            let list = records.first().map(|r| arguments(r.1)).ok_or("a record has no list of arguments")?;
            let name = list.first().and_then(|n| string(n)).unwrap_or_default();
            let kind = if FACES.contains(&word) { &mut self.faces } else { &mut self.solids };
            kind.push(StepFace { id, name });
        } else if TESSELLATED.contains(&word) {
            self.tessellated += 1;
        } else if word.is_empty() {
            let records = records(value);
            let shapes = records.iter().any(|r| r.0 == b"GEOMETRIC_REPRESENTATION_CONTEXT");
            if let Some((_, list)) = records.iter().find(|r| r.0 == b"GLOBAL_UNIT_ASSIGNED_CONTEXT").filter(|_| shapes)
            {
                let ids = arguments(arguments(list).first().unwrap_or(&b"".as_slice()));
                self.contexts.push((id, ids.iter().filter_map(|r| reference(r)).collect()));
            } else if records.iter().any(|r| is_of_unit(r.0)) {
                self.units.insert(id, value);
            }
        } else if is_of_unit(word) {
            self.units.insert(id, value);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str =
        "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n";
    const TAIL: &str = "ENDSEC;\nEND-ISO-10303-21;\n";
    const MM: &str = "#90=(GEOMETRIC_REPRESENTATION_CONTEXT(3) GLOBAL_UNIT_ASSIGNED_CONTEXT((#91,#92)) REPRESENTATION_CONTEXT('',''));\n\
                      #91=(LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.));\n\
                      #92=(NAMED_UNIT(*) PLANE_ANGLE_UNIT() SI_UNIT($,.RADIAN.));\n";
    const SOLID: &str = "#5=MANIFOLD_SOLID_BREP('plate',#6);\n#6=CLOSED_SHELL('',(#7,#8));\n\
                         #7=ADVANCED_FACE('datum face A',(#18),#32,.F.);\n#8=ADVANCED_FACE('',(#18),#32,.T.);\n";

    fn read(text: &str) -> Result<StepText, String> {
        StepText::read(Path::new("part.step"), text.as_bytes()).map_err(|e| format!("{e}; {}", e.help()))
    }

    #[test]
    fn faces_solids_and_unit_are_counted() {
        let text = read(&format!("{HEAD}{MM}{SOLID}{TAIL}")).expect("a file");
        assert_eq!((text.schema.as_str(), text.unit.millimeters), ("AUTOMOTIVE_DESIGN", 1.0));
        assert_eq!(text.solids, [StepFace { id: 5, name: "plate".into() }]);
        assert_eq!(text.faces.iter().map(StepFace::shown).collect::<Vec<_>>(), ["#7 \"datum face A\"", "#8"]);
        // A comment counts nothing, nor does a string.
        let more = "/* #50=ADVANCED_FACE('',(#1),#2,.T.); */ #51=PRODUCT('#52=ADVANCED_FACE(;');\n";
        let text = read(&format!("{HEAD}{MM}{SOLID}{more}{TAIL}")).expect("a file");
        assert_eq!(text.faces.len(), 2);
    }

    /// A file that is cut off anywhere is refused, never read as a smaller one.
    #[test]
    fn a_file_that_ends_early_is_refused_at_every_length() {
        let whole = format!("{HEAD}{MM}{SOLID}{TAIL}");
        let end = whole.trim_end().len();
        assert!(read(&whole[..end]).is_ok());
        for length in 0..end {
            assert!(read(&whole[..length]).is_err(), "{length} bytes");
        }
        let cut = read(&whole[..whole.find("'datum").expect("there") + 3]).expect_err("cut off");
        assert!(cut.contains("part.step:11") && cut.contains("not whole"), "{cut}");
    }

    #[test]
    fn units_are_one_and_understood() {
        let metre = MM.replace(".MILLI.", "$");
        assert_eq!(read(&format!("{HEAD}{metre}{SOLID}{TAIL}")).expect("meters").unit.millimeters, 1000.0);
        let other = MM.replace("#9", "#19").replace(".MILLI.", ".CENTI.");
        let two = read(&format!("{HEAD}{MM}{other}{SOLID}{TAIL}")).expect_err("two units");
        assert!(two.contains("two units: millimetre (context #90) and centimetre (context #190)"), "{two}");
        let same = MM.replace("#9", "#19");
        assert!(read(&format!("{HEAD}{MM}{same}{SOLID}{TAIL}")).is_ok(), "the same unit twice is one");
        assert!(read(&format!("{HEAD}{SOLID}{TAIL}")).expect_err("none").contains("states no unit"));
        let odd = MM.replace(".MILLI.", ".PICO.");
        assert!(read(&format!("{HEAD}{odd}{SOLID}{TAIL}")).expect_err("odd").contains("#91 of its context #90"));
    }

    #[test]
    fn what_encloses_nothing_is_refused_by_what_it_is() {
        for (text, words) in [
            (format!("{HEAD}{MM}#7=ADVANCED_FACE('',(#18),#32,.F.);\n{TAIL}"), "1 faces and no solid"),
            (format!("{HEAD}{MM}{TAIL}"), "no solid and no face"),
            (format!("{HEAD}{MM}#7=TESSELLATED_SOLID('',$,$);\n{TAIL}"), "1 bodies of triangles"),
            (format!("{HEAD}{MM}#x=TESSELLATED_SOLID('',$,$);\n{TAIL}"), "part.step:9: an instance needs a number"),
            ("solid cube\nfacet".to_owned(), "no STEP file"),
            (String::new(), "no STEP file"),
        ] {
            let refused = read(&text).expect_err(words);
            assert!(refused.contains(words), "{refused}");
        }
    }
}
