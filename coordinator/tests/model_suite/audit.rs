//! What must be true after every step.

use super::farm::{BLOCKS, Farm, Unit};

/// What is wrong with a farm, if anything.
pub(crate) fn audit(farm: &Farm) -> Result<(), &'static str> {
    for name in farm.named() {
        if !farm.objects.contains_key(&name) {
            return Err("a row names an object that is not there");
        }
    }
    let mut counted = [0u8; BLOCKS];
    let mut folded = [0u8; BLOCKS];
    for part in &farm.parts {
        for block in part.run.first..part.run.end {
            counted[usize::from(block)] += 1;
            folded[usize::from(block)] += u8::from(part.object.is_none());
        }
    }
    for (unit, parts) in farm.units.iter().zip(counted) {
        if parts != u8::from(*unit == Unit::Counted) {
            return Err("a counted unit is not in exactly one part");
        }
    }
    let film = farm.tile.object.and_then(|name| farm.objects.get(&name));
    if film.copied().unwrap_or_default() != folded {
        return Err("the film is not the sum of the folded parts");
    }
    if farm.finished.is_some_and(|sum| sum != [1; BLOCKS]) {
        return Err("the finished film lacks a block or has one twice");
    }
    if farm.false_word {
        return Err("a worker was told of a result that is not counted");
    }
    Ok(())
}
