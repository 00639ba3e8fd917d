//! The group whose members may be clients of a service, besides its own user.

use super::Misfit;
use core::fmt;

/// Where the machine's own groups are. Those of a directory service are named by their numbers.
const GROUPS: &str = "/etc/group";

/// A group of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClientGroup {
    /// By its name.
    Name(String),
    /// By its number.
    Id(u32),
}

impl fmt::Display for ClientGroup {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(f, "{name:?}"),
            Self::Id(id) => write!(f, "{id}"),
        }
    }
}

impl ClientGroup {
    /// As it is written in a deployment. Nothing is looked up.
    pub(super) fn of(written: &toml::Value) -> Result<Self, Misfit> {
        let id = written.as_integer().map(u32::try_from);
        match (written.as_str(), id) {
            (Some(name), _) if !name.is_empty() && !name.contains([':', '\n']) => {
                Ok(Self::Name(name.to_owned()))
            }
            // The last number means "no group" to the system.
            (_, Some(Ok(id))) if id != u32::MAX => Ok(Self::Id(id)),
            _ => {
                let help = "write group = \"planners\", or its number";
                Err(("group", format!("{written} is not a group"), help.to_owned()))
            }
        }
    }

    /// Its number, if this user may give files to it.
    pub(super) fn find(&self) -> Result<u32, Misfit> {
        let id = match self {
            Self::Id(id) => *id,
            Self::Name(name) => {
                let groups = std::fs::read_to_string(GROUPS).unwrap_or_default();
                id_in(&groups, name).ok_or_else(|| {
                    let help = format!("groupadd {name}, or write the number of a group");
                    ("group", format!("there is no group {self} in {GROUPS}"), help)
                })?
            }
        };
        if !transport::folder::is_member(id) {
            let help = "add the user to it (usermod -aG, or SupplementaryGroups= of the unit), \
                        and start anew";
            let fault = format!("the user of the service is not in group {self}");
            return Err(("group", fault, help.to_owned()));
        }
        Ok(id)
    }
}

/// The number of a group in the text of group(5).
fn id_in(groups: &str, name: &str) -> Option<u32> {
    groups.lines().find_map(|line| {
        let mut fields = line.split(':');
        (fields.next()? == name).then(|| fields.nth(1)?.parse().ok())?
    })
}

#[cfg(test)]
mod tests {
    //! A group is found by name or number, or refused with a remedy.
    use super::*;

    #[test]
    fn a_name_is_found_as_a_whole_and_alone() {
        let groups = "planners2:x:7:\nplanners:x:1002:ann,bob\nbroken:x\nplanner:x:9:\n";
        assert_eq!(id_in(groups, "planners"), Some(1002));
        assert_eq!(id_in(groups, "planner"), Some(9));
        assert_eq!((id_in(groups, "broken"), id_in(groups, "plan")), (None, None));
    }

    #[test]
    fn what_is_no_group_is_refused() {
        for written in ["-1", "4294967295", "\"\"", "\"a:b\"", "true", "1.5"] {
            let value: toml::Value = toml::from_str::<toml::Table>(&format!("group = {written}"))
                .unwrap()
                .remove("group")
                .unwrap();
            let (key, fault, _) = ClientGroup::of(&value).unwrap_err();
            assert_eq!(key, "group");
            assert!(fault.contains("is not a group"), "{fault}");
        }
        let (_, fault, help) = ClientGroup::Name("no-such-group".to_owned()).find().unwrap_err();
        assert!(fault.contains("\"no-such-group\"") && help.contains("groupadd"), "{fault}");
        let own = ClientGroup::Name("root".to_owned()).find();
        assert!(matches!(own, Ok(0) | Err(("group", ..))), "{own:?}");
    }
}
