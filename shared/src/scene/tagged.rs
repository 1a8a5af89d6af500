//! Reading `{"type": "...", ...}` without losing the place of an error, and
//! maps without repeated keys.
//!
//! Serde's own internally tagged enums buffer the object and then forget where
//! in it an error was; and a map keeps the last of two equal keys silently.
//! Here the object is read as JSON values, the tag is taken out, and the rest
//! is read by the type that the tag names, whose error carries its path.

use serde::de::{self, DeserializeOwned, Deserializer, MapAccess, Visitor};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// Between the path inside a tagged object and the message, on the way from
/// `variant` to [`split_error`]: a character that no message contains.
const PATH_MARK: char = '\u{1f}';

/// An object with its `type` taken out.
pub(super) struct Tagged {
    /// The tag.
    pub(super) kind: String,
    /// All other fields.
    fields: Map<String, Value>,
}

/// Read an object that must have a `type`.
pub(super) fn tagged<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Tagged, D::Error> {
    let mut fields: Map<String, Value> = deserializer.deserialize_map(Unique::new())?;
    match fields.remove("type") {
        Some(Value::String(kind)) => Ok(Tagged { kind, fields }),
        Some(other) => Err(failed("type", &format!("{other}: expected a string"))),
        None => Err(de::Error::missing_field("type")),
    }
}

impl Tagged {
    /// The fields as the type that the tag stands for.
    pub(super) fn read<T: DeserializeOwned, E: de::Error>(self) -> Result<T, E> {
        serde_path_to_error::deserialize(Value::Object(self.fields)).map_err(|e| {
            let path = e.path().to_string();
            failed(&path, &e.inner().to_string())
        })
    }

    /// The error for a tag that is none of `expected`.
    pub(super) fn unknown<E: de::Error>(&self, expected: &[&str]) -> E {
        let list: Vec<String> = expected.iter().map(|name| format!("`{name}`")).collect();
        failed(
            "type",
            &format!("`{}`: expected {}", self.kind, list.join(" or ")),
        )
    }
}

fn failed<E: de::Error>(path: &str, message: &str) -> E {
    E::custom(format_args!("{path}{PATH_MARK}{message}"))
}

/// Join the path of an outer error with the one that its message may carry.
pub(super) fn split_error(path: &str, message: &str) -> (String, String) {
    let path = if path.is_empty() { "." } else { path };
    let Some((inner, message)) = message.split_once(PATH_MARK) else {
        return (path.to_owned(), message.to_owned());
    };
    let joined = match (path, inner) {
        (outer, "" | ".") => outer.to_owned(),
        (".", inner) => inner.to_owned(),
        (outer, inner) if inner.starts_with('[') => format!("{outer}{inner}"),
        (outer, inner) => format!("{outer}.{inner}"),
    };
    // A tagged object inside a tagged object.
    split_error(&joined, message)
}

/// For `#[serde(deserialize_with)]`: a map whose keys are all different.
pub(super) fn unique_map<'de, D, T>(deserializer: D) -> Result<BTreeMap<String, T>, D::Error>
where
    D: Deserializer<'de>,
    T: de::Deserialize<'de>,
{
    deserializer.deserialize_map(Unique::new())
}

/// What can take entries of an object.
trait Entries<T>: Default {
    fn holds(&self, key: &str) -> bool;
    fn add(&mut self, key: String, value: T);
}

impl<T> Entries<T> for BTreeMap<String, T> {
    fn holds(&self, key: &str) -> bool {
        self.contains_key(key)
    }
    fn add(&mut self, key: String, value: T) {
        self.insert(key, value);
    }
}

impl Entries<Value> for Map<String, Value> {
    fn holds(&self, key: &str) -> bool {
        self.contains_key(key)
    }
    fn add(&mut self, key: String, value: Value) {
        self.insert(key, value);
    }
}

struct Unique<M, T>(PhantomData<(M, T)>);

impl<M, T> Unique<M, T> {
    const fn new() -> Self {
        Self(PhantomData)
    }
}

impl<'de, M: Entries<T>, T: de::Deserialize<'de>> Visitor<'de> for Unique<M, T> {
    type Value = M;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<M, A::Error> {
        let mut entries = M::default();
        while let Some(key) = access.next_key::<String>()? {
            if entries.holds(&key) {
                return Err(de::Error::custom(format_args!("`{key}` stands here twice")));
            }
            let value = access.next_value()?;
            entries.add(key, value);
        }
        Ok(entries)
    }
}

/// Implement `Deserialize` for an enum whose variants each hold one struct and
/// are told apart by `type`. The JSON Schema still comes from serde's `tag`.
macro_rules! tagged_enum {
    ($name:ident { $($tag:literal => $variant:ident),+ $(,)? }) => {
        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(
                deserializer: D,
            ) -> Result<Self, D::Error> {
                let tagged = $crate::scene::tagged::tagged(deserializer)?;
                match tagged.kind.as_str() {
                    $($tag => tagged.read().map($name::$variant),)+
                    _ => Err(tagged.unknown(&[$($tag),+])),
                }
            }
        }
    };
}
pub(super) use tagged_enum;
