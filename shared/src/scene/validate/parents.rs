//! Names of instances, and who is placed in whose space.

use super::super::at::At;
use super::super::range::{count, list_known};
use super::super::{Instance, SceneError};
use crate::limits::{INSTANCE_DEPTH_MAX, NAME_BYTES_MAX};
use std::collections::BTreeMap;

/// Names are unique, every parent exists, and no chain of parents is too long or
/// comes back to itself.
pub(super) fn parents(at: &At<'_>, instances: &[Instance]) -> Result<(), SceneError> {
    let mut named: BTreeMap<&str, usize> = BTreeMap::new();
    for (i, instance) in instances.iter().enumerate() {
        let Some(name) = &instance.name else {
            continue;
        };
        let instance_at = at.index(i);
        let name_at = instance_at.field("name");
        count(&name_at, name.len() as u64, 1, NAME_BYTES_MAX as u64)
            .map_err(|e| name_at.error(format!("{} bytes", e.message)))?;
        if let Some(other) = named.insert(name, i) {
            return Err(name_at.error(format!(
                "`{name}` is also the name of instances[{other}]: expected a name of its own"
            )));
        }
    }
    for i in 0..instances.len() {
        chain(at, instances, &named, i)?;
    }
    Ok(())
}

fn chain(
    at: &At<'_>,
    instances: &[Instance],
    named: &BTreeMap<&str, usize>,
    first: usize,
) -> Result<(), SceneError> {
    let at = at.index(first);
    let at = at.field("parent");
    let mut current = first;
    for _ in 0..INSTANCE_DEPTH_MAX {
        let Some(parent) = &instances[current].parent else {
            return Ok(());
        };
        let Some(&next) = named.get(parent.as_str()) else {
            if current != first {
                // Said at the instance that names it.
                return Ok(());
            }
            let known = instances.iter().filter_map(|i| i.name.as_ref());
            return Err(at.error(format!(
                "`{parent}`: no instance of that name; {}",
                list_known(known)
            )));
        };
        if next == first {
            return Err(at.error(format!(
                "`{parent}`: expected no instance that is placed within this one"
            )));
        }
        current = next;
    }
    Err(at.error(format!(
        "more than {INSTANCE_DEPTH_MAX} instances from here to the world, or a circle: \
         expected at most {INSTANCE_DEPTH_MAX}"
    )))
}
