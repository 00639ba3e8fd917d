//! Places and shapes of CommonRoad.

use crate::error::TrafficError;
use crate::outline::{Outline, OutlinePart, corners};
use crate::xml::Element;

/// Least and greatest extent of a shape (m): a hand, and the longest train at a platform. Beyond
/// lies a wrong unit.
pub(crate) const EXTENT_M: [f64; 2] = [0.05, 500.0];
/// Greatest distance from the origin (m): coordinates of maps have up to seven digits.
pub(crate) const COORDINATE_M: f64 = 1e8;

/// A place, and the region of which it is the middle.
pub(super) fn position(element: Element<'_>) -> Result<([f64; 2], Option<Outline>), TrafficError> {
    if let Some(at) = element.get("point") {
        return Ok((point(at)?, None));
    }
    if element.get("lanelet").is_some() {
        let help = "give a point or a region in coordinates";
        return Err(element.fault("a lanelet says no place", help));
    }
    let region = shape(element)?;
    Ok((region.middle(), Some(region)))
}

fn point(element: Element<'_>) -> Result<[f64; 2], TrafficError> {
    let mut at = [0.0; 2];
    for (value, name) in at.iter_mut().zip(["x", "y"]) {
        let part = element.need(name)?;
        *value = part.number()?;
        if value.abs() > COORDINATE_M {
            let fault = format!("{name} is {value} m");
            return Err(part.fault(fault, format!("at most {COORDINATE_M} m from the origin")));
        }
    }
    Ok(at)
}

/// Rectangles, circles and polygons, one or several.
pub(super) fn shape(element: Element<'_>) -> Result<Outline, TrafficError> {
    let mut parts = Vec::new();
    for part in element.children() {
        let extent = |name: &str| -> Result<f64, TrafficError> {
            let element = part.need(name)?;
            let value = element.number()?;
            let [least, most] = EXTENT_M;
            if !(least..=most).contains(&value) {
                let fault = format!("a {name} of {value} m");
                return Err(element.fault(fault, format!("{least} to {most} m: a wrong unit?")));
            }
            Ok(value)
        };
        let centre = || part.get("center").map_or(Ok([0.0; 2]), point);
        parts.push(match part.name() {
            "rectangle" => {
                let yaw = part.get("orientation").map_or(Ok(0.0), |yaw| yaw.number())?;
                OutlinePart::Polygon(corners(extent("length")?, extent("width")?, centre()?, yaw))
            }
            "circle" => OutlinePart::Circle(centre()?, extent("radius")?),
            "polygon" => polygon(part)?,
            other => {
                let fault = format!("shape <{other}> is not known");
                return Err(part.fault(fault, "known are rectangle, circle and polygon"));
            }
        });
    }
    if parts.is_empty() {
        return Err(element.fault("it has no shape", "add a rectangle, circle or polygon"));
    }
    Ok(Outline { parts })
}

fn polygon(element: Element<'_>) -> Result<OutlinePart, TrafficError> {
    let points = element.all("point").map(point).collect::<Result<Vec<_>, _>>()?;
    let part = OutlinePart::Polygon(points);
    let outline = Outline { parts: vec![part] };
    let [length, width] = outline.size();
    let [least, most] = EXTENT_M;
    let Some(part) = outline.parts.into_iter().next() else {
        return Err(element.fault("it has no corners", "give at least three"));
    };
    match &part {
        OutlinePart::Polygon(points) if points.len() < 3 => {
            Err(element.fault("it has fewer than three corners", "give at least three"))
        }
        _ if !(length.min(width) >= least && length.max(width) <= most) => {
            let fault = format!("a polygon of {length:.3} × {width:.3} m");
            Err(element.fault(fault, format!("{least} to {most} m each way: a wrong unit?")))
        }
        _ => Ok(part),
    }
}
