//! How well parties are known, and in how many members that is followed.

use crate::document::Path;
use crate::fault::Fault;
use crate::fields;
use crate::limit;
use crate::members::{Errors, Members};
use crate::raw::Table;
use crate::scenario::raw;

/// How many members a scenario asks for, if it says so.
pub(super) fn members(count: Option<i64>, most: Option<i64>) -> Result<Option<Members>, Fault> {
    if (count, most) == (None, None) {
        return Ok(None);
    }
    let members = Members::new(count.unwrap_or(i64::from(Members::USUAL.count)), most);
    members.map(Some).map_err(|misfit| Fault { path: Path::default().key(misfit.setting), misfit })
}

/// How well a party is known.
pub(super) fn errors(
    written: Option<Table<raw::Errors>>,
    is_ego: bool,
    path: &Path,
) -> Result<Errors, Fault> {
    let usual = Errors::usual(is_ego);
    let Some(Table(raw)) = written else { return Ok(usual) };
    let number = |value, setting, limit, usual: f64| {
        Ok::<_, Fault>(fields::number(value, setting, limit, path)?.unwrap_or(usual))
    };
    let (lateral, longitudinal) = (usual.lateral_m, usual.longitudinal_m);
    Ok(Errors {
        lateral_m: number(raw.lateral_m, "lateral_m", limit::ERROR_M, lateral)?,
        longitudinal_m: number(raw.longitudinal_m, "longitudinal_m", limit::ERROR_M, longitudinal)?,
        correlation: number(raw.correlation, "correlation", limit::CORRELATION, 0.0)?,
        yaw_deg: number(raw.yaw_deg, "yaw_deg", limit::ERROR_YAW_DEG, usual.yaw_deg)?,
        speed_share: number(
            raw.speed_share,
            "speed_share",
            limit::ERROR_SPEED_SHARE,
            usual.speed_share,
        )?,
    })
}
