//! The document of measured features, read back.

use super::*;

fn plan() -> [PlannedFeature; 3] {
    let of = |from, direction: &str, thickness| {
        let (axis, sign) = probe_direction(direction).expect("a direction");
        PlannedFeature { from, axis, sign, thickness }
    };
    [of([50.0, 3.0, 30.0], "-z", false), of([0.0, 0.0, -5.0], "+x", true), of([-9.0, 4.0, -5.0], "+x", false)]
}

fn feature(name: &str, nominal_mm: f64, tolerance_mm: f64, measured_mm: Option<f64>) -> Inspected {
    Inspected { name: name.into(), nominal_mm, measured_mm, tolerance_mm }
}

/// Values between the tags of a name.
fn between<'a>(text: &'a str, tag: &str) -> Vec<&'a str> {
    let (open, close) = (format!("<{tag}>"), format!("</{tag}>"));
    text.split(&open).skip(1).filter_map(|t| t.split(&close).next()).collect()
}

/// Name of an element, and its children in the order of the published type. Children that are not written
/// are left out where the type has them between two that are (QIF 3.0: `QIFDocumentType`,
/// `QIFDocumentHeaderType`, `ResultsType`, `MeasurementResultsType`, `CharacteristicItemBaseType`,
/// `CharacteristicNominalBaseType`, `CharacteristicMeasurementBaseType` followed by what the linear
/// coordinate adds, `PointFeatureNominalType`, `PointFeatureItemType`, `PointFeatureMeasurementType`).
const ORDERS: [(&str, &[&str]); 19] = [
    (
        "QIFDocument",
        &[
            "QPId",
            "Version",
            "Header",
            "FileUnits",
            "Product",
            "Features",
            "Characteristics",
            "Plan",
            "Results",
            "Statistics",
        ],
    ),
    ("Header", &["Application", "Author", "ApplicationSource", "Description", "Scope"]),
    ("FileUnits", &["PrimaryUnits", "OtherUnits"]),
    ("Features", &["FeatureDefinitions", "FeatureNominals", "FeatureItems"]),
    ("Characteristics", &["CharacteristicDefinitions", "CharacteristicNominals", "CharacteristicItems"]),
    ("Results", &["Version", "MeasurementResultsSet", "ActualComponentSets", "InspectionTraceability"]),
    ("MeasurementResultsSet", &["MeasurementResults"]),
    (
        "MeasurementResults",
        &[
            "Attributes",
            "InspectionTraceability",
            "ThisResultsInstanceQPId",
            "ExternalFileReferences",
            "MeasuredFeatures",
            "MeasuredPointSets",
            "MeasuredCharacteristics",
            "ActualTransforms",
            "InspectionStatus",
            "ActualComponentIds",
        ],
    ),
    ("PointFeatureNominal", &["FeatureDefinitionId", "Location", "Normal"]),
    ("PointFeatureItem", &["FeatureNominalId", "FeatureName", "DeterminationMode"]),
    ("PointFeatureMeasurement", &["FeatureItemId", "Location", "Normal"]),
    ("LinearCoordinateCharacteristicDefinition", &["Name", "Tolerance"]),
    ("ThicknessCharacteristicDefinition", &["Name", "Tolerance"]),
    (
        "LinearCoordinateCharacteristicNominal",
        &["CharacteristicDefinitionId", "FeatureNominalIds", "Name", "TargetValue", "Direction"],
    ),
    ("ThicknessCharacteristicNominal", &["CharacteristicDefinitionId", "FeatureNominalIds", "Name", "TargetValue"]),
    (
        "LinearCoordinateCharacteristicItem",
        &["Name", "CharacteristicDesignator", "FeatureItemIds", "CharacteristicNominalId"],
    ),
    ("ThicknessCharacteristicItem", &["Name", "CharacteristicDesignator", "FeatureItemIds", "CharacteristicNominalId"]),
    (
        "LinearCoordinateCharacteristicMeasurement",
        &["Status", "CharacteristicItemId", "TimeStamp", "FeatureMeasurementIds", "Value", "TypeOfCoordinates"],
    ),
    (
        "ThicknessCharacteristicMeasurement",
        &["Status", "CharacteristicItemId", "TimeStamp", "FeatureMeasurementIds", "Value"],
    ),
];

/// A reference, and what its id must be of: each kind of characteristic refers to its own kind.
fn referred(tag: &str, parent: &str) -> Option<String> {
    let kind = |step: &str| {
        let stem = ["Definition", "Nominal", "Item", "Measurement"].iter().find_map(|end| parent.strip_suffix(end));
        Some(format!("{}{step}", stem.unwrap_or(parent)))
    };
    match tag {
        "FeatureDefinitionId" | "CharacteristicDefinitionId" => kind("Definition"),
        "FeatureNominalId" | "CharacteristicNominalId" => kind("Nominal"),
        "FeatureItemId" | "CharacteristicItemId" => kind("Item"),
        "Id" if parent == "FeatureItemIds" => Some("PointFeatureItem".into()),
        "Id" if parent == "FeatureMeasurementIds" => Some("PointFeatureMeasurement".into()),
        _ => None,
    }
}

/// What a document has wrong against namespace, orders, counts and references, as a reader of XML finds it.
fn wrong(text: &str) -> Vec<String> {
    let document = match roxmltree::Document::parse(text) {
        Ok(document) => document,
        Err(e) => return vec![e.to_string()],
    };
    let mut out = Vec::new();
    let (mut ids, mut references) = (std::collections::BTreeMap::new(), Vec::new());
    for element in document.descendants().filter(roxmltree::Node::is_element) {
        let name = element.tag_name().name();
        if element.tag_name().namespace() != Some("http://qifstandards.org/xsd/qif3") {
            out.push(format!("{name} is of another namespace"));
        }
        let children: Vec<&str> =
            element.children().filter(roxmltree::Node::is_element).map(|c| c.tag_name().name()).collect();
        if let Some((_, order)) = ORDERS.iter().find(|(tag, _)| *tag == name) {
            let places: Vec<Option<usize>> = children.iter().map(|c| order.iter().position(|o| o == c)).collect();
            if places.iter().any(Option::is_none) || !places.is_sorted() {
                out.push(format!("{name} has {children:?}"));
            }
        }
        if let Some(n) = element.attribute("n").filter(|n| n.parse() != Ok(children.len())) {
            out.push(format!("{name} counts {n} of {}", children.len()));
        }
        if let Some(id) = element.attribute("id")
            && ids.insert(id.to_owned(), name.to_owned()).is_some()
        {
            out.push(format!("id {id} occurs twice"));
        }
        let parent = element.parent().map_or("", |p| p.tag_name().name());
        if let Some(of) = referred(name, parent) {
            references.push((element.text().unwrap_or_default().to_owned(), of));
        }
    }
    for (id, of) in references {
        if ids.get(&id) != Some(&of) {
            out.push(format!("{id} is no {of}"));
        }
    }
    let largest = ids.keys().filter_map(|id| id.parse::<usize>().ok()).max();
    if document.root_element().attribute("idMax").and_then(|m| m.parse().ok()) != largest {
        out.push(format!("idMax is not {largest:?}"));
    }
    out
}

#[test]
fn a_reader_finds_the_published_order_and_every_reference() {
    let features = [
        feature("top", -2.0, 0.05, Some(-2.01)),
        feature("rib & <web>", 4.0, 0.1, Some(4.2)),
        feature("side", 1.0, 0.02, None),
    ];
    let text = inspection_qif(&features, &plan(), "scene plate").expect("features");
    assert_eq!(wrong(&text), Vec::<String>::new(), "{text}");
    let one = inspection_qif(&features[1..2], &plan()[1..2], "scene plate").expect("a feature");
    assert_eq!(wrong(&one), Vec::<String>::new(), "a thickness alone has no features: {one}");
    for tag in [
        "Features",
        "LinearCoordinateCharacteristicMeasurement",
        "ThicknessCharacteristicItem",
        "PointFeatureMeasurement",
    ] {
        assert!(text.contains(&format!("<{tag}")), "{tag}");
    }
    // The check finds what is wrong.
    for (from, to) in [
        ("xsd/qif3\" xmlns", "xsd/qif2\" xmlns"),
        ("<FeatureItemId>3<", "<FeatureItemId>4<"),
        ("<CharacteristicItemId>16<", "<CharacteristicItemId>6<"),
        ("<FeatureDefinitions n=\"2\"", "<FeatureDefinitions n=\"3\""),
        ("<QPId>", "<Header/><QPId>"),
        ("idMax=\"31\"", "idMax=\"30\""),
        ("</Results>", ""),
    ] {
        assert!(text.contains(from), "{from} is not in {text}");
        assert!(!wrong(&text.replacen(from, to, 1)).is_empty(), "{from} as {to}");
    }
}

#[test]
fn values_places_and_judgements_are_those_of_the_features() {
    let features = [
        feature("top", -2.0, 0.05, Some(-2.01)),
        feature("rib <1>", 4.0, 0.1, Some(4.2)),
        feature("side", 1.0, 0.02, None),
    ];
    let text = inspection_qif(&features, &plan(), "scene plate").expect("features");
    assert_eq!(between(&text, "Value"), ["-2.010000", "4.200000"], "what met nothing has no value");
    assert_eq!(between(&text, "CharacteristicStatusEnum"), ["PASS", "FAIL"]);
    assert_eq!(between(&text, "InspectionStatusEnum"), ["FAIL"]);
    assert_eq!(between(&text, "TargetValue"), ["-2.000000", "4.000000", "1.000000"]);
    assert_eq!(between(&text, "Direction"), ["ZAXIS", "XAXIS"], "a thickness has none");
    let places = ["50.000000 3.000000 -2.000000", "1.000000 4.000000 -5.000000", "50.000000 3.000000 -2.010000"];
    assert_eq!(between(&text, "Location"), places);
    assert_eq!(between(&text, "Normal"), ["0.000000 0.000000 1.000000", "-1.000000 0.000000 0.000000"]);
    assert_eq!(between(&text, "Name"), ["proveout", "top", "rib &lt;1&gt;", "side"]);
    // Every id once, every reference to one that is there, none above the largest.
    let ids: Vec<usize> = text.split(" id=\"").skip(1).filter_map(|t| t.split('"').next()?.parse().ok()).collect();
    let mut once = ids.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), ids.len(), "{ids:?}");
    for tag in [
        "FeatureDefinitionId",
        "FeatureNominalId",
        "FeatureItemId",
        "CharacteristicDefinitionId",
        "CharacteristicNominalId",
        "CharacteristicItemId",
        "Id",
    ] {
        for value in between(&text, tag) {
            assert!(once.contains(&value.parse().expect("a number")), "{tag} {value}");
        }
    }
    assert!(text.contains(&format!("idMax=\"{}\"", once[once.len() - 1])), "{once:?}");
    // Tags close in order.
    let mut open: Vec<&str> = Vec::new();
    for tag in text.split('<').skip(2).filter_map(|t| t.split('>').next()) {
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') => {}
            None => open.push(tag.split(' ').next().unwrap_or_default()),
        }
    }
    assert!(open.is_empty(), "{open:?}");
    // The same run, the same bytes; another result, another document.
    assert_eq!(inspection_qif(&features, &plan(), "scene plate").as_deref(), Some(text.as_str()));
    let other = inspection_qif(
        &[features[0].clone(), features[1].clone(), feature("side", 1.0, 0.02, Some(1.0))],
        &plan(),
        "scene plate",
    );
    assert_ne!(other.map(|t| between(&t, "QPId")[0].to_owned()), Some(between(&text, "QPId")[0].to_owned()));
    assert!(inspection_qif(&[], &[], "").is_none());
}
