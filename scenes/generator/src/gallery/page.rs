//! The gallery as a page.

use super::{Gallery, Group, Measured};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Digits of a film hash that tell two pictures apart at a glance.
const HASH_DIGITS: usize = 12;

/// The page in Markdown.
pub(super) fn write(list: &Gallery, measured: &BTreeMap<String, Measured>) -> String {
    let mut page = String::from("# Gallery\n\n");
    page.push_str(&list.text);
    page.push_str(
        "\n\nMade by `cargo run --release -p shearwater-scenes -- gallery`; do not edit.\n",
    );
    for group in &list.groups {
        write_group(&mut page, group, measured);
    }
    page
}

// Writing to a string cannot fail.
fn write_group(page: &mut String, group: &Group, measured: &BTreeMap<String, Measured>) {
    let _ = write!(page, "\n## {}\n\n{}\n", group.title, group.text);
    for listed in &group.pictures {
        let (name, caption) = (&listed.name, &listed.caption);
        let _ = write!(page, "\n![{caption}](gallery/{name}.png)\n\n{caption}\n");
    }
    let _ = write!(
        page,
        "\n| picture | command | seconds | NMSE | film |\n|---|---|---|---|---|\n"
    );
    for listed in &group.pictures {
        if let Some(m) = measured.get(&listed.name) {
            let hash = m.film_hash.get(..HASH_DIGITS).unwrap_or_default();
            let _ = writeln!(
                page,
                "| {} | `shearwater {}` | {:.1} | {} | `{hash}` |",
                listed.name,
                m.args.join(" "),
                m.seconds,
                m.nmse
                    .map_or("exact".to_owned(), |nmse| format!("{nmse:.1e}"))
            );
        }
    }
}
