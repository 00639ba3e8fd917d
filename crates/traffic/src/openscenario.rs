//! OpenSCENARIO XML 1.x, as far as it says where bodies are: entities with bounding boxes (their
//! own, or from catalogues), and the initial world position and speed of each.
//!
//! The story is not executed: every entity keeps course and speed, and a note says so. Positions on
//! a road, a lane or a route need a road network and are refused; so are expressions in `${…}`.

use crate::error::TrafficError;
use crate::outline::{Outline, OutlinePart, Placed, corners};
use crate::recording::{Ego, Obstacle, Recording, TimedState, wrapped};
use crate::xml::{Document, Element};
use crate::{NamedText, ReadOptions};
use std::collections::BTreeMap;

/// How far ahead everybody's course is drawn (s): beyond any horizon.
const AHEAD_S: f64 = 60.0;
/// Least and greatest extent of a bounding box (m).
const EXTENT_M: [f64; 2] = [0.05, 500.0];

/// The type of an obstacle for a category of OpenSCENARIO.
fn kind(category: &str) -> &str {
    match category {
        "car" | "van" => "car",
        "truck" | "semitrailer" | "trailer" => "truck",
        "bus" | "train" | "bicycle" | "pedestrian" => category,
        "motorbike" => "motorcycle",
        "wheelchair" => "pedestrian",
        "pole" | "tree" | "streetLamp" => "pillar",
        "building" => "building",
        "barrier" | "guardRail" | "wall" | "soundBarrier" | "railing" => "roadBoundary",
        "obstacle" | "none" => "unknown",
        other => other,
    }
}

/// Reads a file whose root is `OpenSCENARIO`.
pub(crate) fn read(
    root: Element<'_>,
    options: &ReadOptions<'_>,
) -> Result<Recording, TrafficError> {
    if root.get("Catalog").is_some() {
        let help = "give the scenario that names it, and this file as --catalog FILE";
        return Err(root.fault("this is a catalogue, not a scenario", help));
    }
    let parameters = Parameters::of(root);
    let mut bodies: BTreeMap<&str, (Outline, String)> = BTreeMap::new();
    let mut order = Vec::new();
    for entity in root.need("Entities")?.all("ScenarioObject") {
        let name = entity.need_attribute("name")?;
        if bodies.contains_key(name) {
            return Err(entity.fault("two entities have this name", "give one another name"));
        }
        bodies.insert(name, entity_body(entity, &parameters, options.catalogs)?);
        order.push((name, entity));
    }
    let init = root.need("Storyboard")?.need("Init")?.need("Actions")?;
    let mut states: BTreeMap<&str, TimedState> = BTreeMap::new();
    for private in init.all("Private") {
        let name = private.need_attribute("entityRef")?;
        let name = parameters.plain(name);
        let Some((known, _)) = bodies.get_key_value(name) else {
            let known = bodies.keys().copied().collect::<Vec<_>>().join(", ");
            let fault = format!("there is no entity {name:?}");
            return Err(private.fault(fault, format!("entities here: {known}")));
        };
        if !options.without.iter().any(|left_out| left_out == name) {
            states.insert(known, initial(private, &parameters)?);
        }
    }
    let (mut ego, mut others) = (None, Vec::new());
    for (name, entity) in order {
        if options.without.iter().any(|left_out| left_out == name) {
            continue;
        }
        let Some(start) = states.get(name).copied() else {
            let help =
                format!("give it a TeleportAction in Init, or leave it out: --without {name}");
            return Err(entity.fault("nothing says where it starts", help));
        };
        let Some((outline, kind)) = bodies.remove(name) else { continue };
        let is_ego = match options.ego {
            Some(asked) => asked == name,
            None => name.eq_ignore_ascii_case("ego"),
        };
        if is_ego {
            ego = Some(Ego { start, outline: Some(outline), went: Vec::new() });
        } else {
            let track = course(start);
            others.push(Obstacle { id: name.to_owned(), kind, outline, track });
        }
    }
    let Some(ego) = ego else {
        return Err(root.fault("no entity is the ego", "name it: --ego NAME"));
    };
    let mut notes = Vec::new();
    if root.get("Storyboard").is_some_and(|board| board.get("Story").is_some()) {
        notes.push("the story is not played: everybody keeps course and speed".to_owned());
    }
    let header = root.get("FileHeader").and_then(|header| header.attribute("description"));
    let name = header.unwrap_or("OpenSCENARIO").chars().take(60).collect::<String>();
    Ok(Recording { name: name.trim().to_owned(), ego, planned: Vec::new(), others, notes })
}

/// Straight on for the whole horizon.
fn course(start: TimedState) -> Vec<TimedState> {
    if start.speed_m_s == 0.0 {
        return vec![start];
    }
    let [x, y] = start.velocity_m_s().map(|v| v * AHEAD_S);
    let at = [start.place.at[0] + x, start.place.at[1] + y];
    let end = TimedState { time_s: AHEAD_S, place: Placed { at, ..start.place }, ..start };
    vec![start, end]
}

/// The values of `$Name` in attributes.
struct Parameters<'d> {
    values: BTreeMap<&'d str, &'d str>,
}

impl<'d> Parameters<'d> {
    fn of(root: Element<'d>) -> Self {
        let declared = root.get("ParameterDeclarations");
        let all = declared.iter().flat_map(|all| all.all("ParameterDeclaration"));
        let pairs = all.filter_map(|one| Some((one.attribute("name")?, one.attribute("value")?)));
        Self { values: pairs.collect() }
    }

    /// The value of a parameter, or the text itself.
    fn plain<'t>(&self, text: &'t str) -> &'t str
    where
        'd: 't,
    {
        let named = text.strip_prefix('$').and_then(|name| self.values.get(name));
        named.copied().unwrap_or(text)
    }

    fn number(&self, element: Element<'_>, name: &str) -> Result<f64, TrafficError> {
        let text = self.plain(element.need_attribute(name)?);
        if text.starts_with('$') {
            let shown: String = text.chars().take(40).collect();
            let fault = format!("{name} = {shown:?} is an expression or an unknown parameter");
            return Err(element.fault(fault, "write its value"));
        }
        match text.trim().parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => Err(element.fault(format!("{name} is not a finite number"), "write a number")),
        }
    }
}

/// The outline of an entity, and its type.
fn entity_body(
    entity: Element<'_>,
    parameters: &Parameters<'_>,
    catalogs: &[NamedText<'_>],
) -> Result<(Outline, String), TrafficError> {
    if let Some(reference) = entity.get("CatalogReference") {
        let entry = parameters.plain(reference.need_attribute("entryName")?);
        for catalog in catalogs {
            let document = Document::parse(catalog.file, catalog.text)?;
            let all = document.root().need("Catalog")?;
            let found = all.children().find(|one| one.attribute("name") == Some(entry));
            if let Some(found) = found {
                // A catalogue declares its own parameters, inside of each entry.
                return body(found, &Parameters::of(found));
            }
        }
        let catalog = reference.attribute("catalogName").unwrap_or("?");
        let fault = format!("no catalogue given here has {entry:?} (of {catalog})");
        return Err(reference.fault(fault, "name the catalogue's file: --catalog FILE"));
    }
    let own = entity
        .children()
        .find(|child| ["Vehicle", "Pedestrian", "MiscObject"].contains(&child.name()));
    match own {
        Some(own) => body(own, parameters),
        None => {
            let help = "known are Vehicle, Pedestrian, MiscObject and CatalogReference";
            Err(entity.fault("nothing says what it is", help))
        }
    }
}

fn body(
    element: Element<'_>,
    parameters: &Parameters<'_>,
) -> Result<(Outline, String), TrafficError> {
    let category = ["vehicleCategory", "pedestrianCategory", "miscObjectCategory"];
    let category = category.iter().find_map(|name| element.attribute(name));
    let Some(category) = category else {
        return Err(element.fault("its category is missing", "add vehicleCategory=\"car\""));
    };
    let bounds = element.need("BoundingBox")?;
    let size = bounds.need("Dimensions")?;
    let extent = |name: &str| -> Result<f64, TrafficError> {
        let value = parameters.number(size, name)?;
        let [least, most] = EXTENT_M;
        if !(least..=most).contains(&value) {
            let fault = format!("a {name} of {value} m");
            return Err(size.fault(fault, format!("{least} to {most} m: a wrong unit?")));
        }
        Ok(value)
    };
    let (length, width) = (extent("length")?, extent("width")?);
    let middle = match bounds.get("Center") {
        Some(centre) => [parameters.number(centre, "x")?, parameters.number(centre, "y")?],
        None => [0.0; 2],
    };
    let part = OutlinePart::Polygon(corners(length, width, middle, 0.0));
    Ok((Outline { parts: vec![part] }, kind(parameters.plain(category)).to_owned()))
}

/// Where an entity starts, and how fast.
fn initial(private: Element<'_>, parameters: &Parameters<'_>) -> Result<TimedState, TrafficError> {
    let mut place = None;
    let mut speed_m_s = 0.0;
    for action in private.all("PrivateAction") {
        if let Some(teleport) = action.get("TeleportAction") {
            let position = teleport.need("Position")?;
            let Some(world) = position.get("WorldPosition") else {
                let what = position.children().next().map_or("nothing", |child| child.name());
                let help = "give a WorldPosition, or play it in a simulator and export CommonRoad";
                let fault = format!("a {what} needs a road network, which is not read");
                return Err(position.fault(fault, help));
            };
            let heading = match world.attribute("h") {
                Some(_) => parameters.number(world, "h")?,
                None => 0.0,
            };
            let at = [parameters.number(world, "x")?, parameters.number(world, "y")?];
            place = Some(Placed { at, yaw: wrapped(heading) });
        }
        let speed = action.get("LongitudinalAction").and_then(|action| action.get("SpeedAction"));
        if let Some(speed) = speed {
            let target = speed.need("SpeedActionTarget")?;
            let Some(absolute) = target.get("AbsoluteTargetSpeed") else {
                let help = "give an AbsoluteTargetSpeed";
                return Err(target.fault("a speed relative to another is not read", help));
            };
            speed_m_s = parameters.number(absolute, "value")?;
        }
    }
    let Some(place) = place else {
        return Err(private.fault("no TeleportAction says where it starts", "add one"));
    };
    Ok(TimedState { time_s: 0.0, place, speed_m_s, slip: 0.0 })
}

#[cfg(test)]
mod tests;
