//! Enums whose variant the key `type` selects, with one line of declaration per type.

use crate::scenario::decode::{DecodeError, NodeDeserializer};
use crate::scenario::findings::Findings;
use crate::text::suggest;
use crate::text::toml_tree::Node;

/// An enum whose variant the key `type` selects.
pub trait Tagged: Sized {
    /// Name of an entry: `task`, `force`.
    const KIND: &'static str;
    /// The known types.
    const TYPES: &'static [&'static str];
    /// Reads an entry (without its `type`) as one of [`Tagged::TYPES`]; `None` for any other.
    fn decode(type_name: &str, entry: NodeDeserializer<'_>) -> Option<Result<Self, DecodeError>>;
}

/// Reads the entry at `path`; errors go to `findings`.
pub fn read<T: Tagged>(entry: &Node, path: &str, findings: &mut Findings) -> Option<T> {
    let kind = T::KIND;
    let Some(tag) = entry.get("type") else {
        if let Some(typo) = entry.entries().iter().find(|e| suggest::nearest(&e.key, ["type"]).is_some()) {
            let message = format!("unknown key `{}` in `{path}`", typo.key);
            findings.error(typo.key_span.clone(), message, Some("did you mean `type`?".into()));
            return None;
        }
        let help = format!("types: {}", T::TYPES.join(", "));
        findings.error(entry.span.clone(), format!("`{path}` lacks the key `type`"), Some(help));
        return None;
    };
    let Some(name) = tag.as_str() else {
        findings.error(tag.span.clone(), format!("`{path}.type` must be a string, not {}", tag.value), None);
        return None;
    };
    let mut rest = entry.clone();
    rest.remove("type");
    match T::decode(name, NodeDeserializer(&rest)) {
        Some(Ok(value)) => return Some(value),
        Some(Err(error)) => error.at(&entry.span).report(path, findings),
        None => {
            let help = suggest::help(name, T::TYPES.iter().copied());
            findings.error(tag.span.clone(), format!("unknown {kind} type `{name}`"), Some(help));
        }
    }
    None
}

/// Declares the enum of all types of one kind and its reader.
macro_rules! tagged {
    ($(#[$doc:meta])* $enum:ident, $kind:literal { $($(#[$variant_doc:meta])* $name:literal => $variant:ident($spec:ty),)* }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
        #[serde(tag = "type")]
        // A scenario has few of these.
        #[allow(clippy::large_enum_variant)]
        pub enum $enum {
            $($(#[$variant_doc])* #[serde(rename = $name)] $variant($spec),)*
        }

        impl $enum {
            /// The values of `type`.
            pub const TYPES: &'static [&'static str] = <Self as $crate::scenario::format::tagged::Tagged>::TYPES;

            /// The value of `type`.
            pub fn type_name(&self) -> &'static str {
                match self {
                    $($enum::$variant(_) => $name,)*
                }
            }
        }

        impl $crate::scenario::format::tagged::Tagged for $enum {
            const KIND: &'static str = $kind;
            const TYPES: &'static [&'static str] = &[$($name),*];

            fn decode(
                type_name: &str,
                entry: $crate::scenario::decode::NodeDeserializer<'_>,
            ) -> Option<Result<Self, $crate::scenario::decode::DecodeError>> {
                match type_name {
                    $($name => Some(serde::Deserialize::deserialize(entry).map($enum::$variant)),)*
                    _ => None,
                }
            }
        }
    };
}
pub(super) use tagged;
