//! TOML text to the structs of a file, with errors in the words of the format.

use crate::nearest::nearest;
use crate::source::Source;
use crate::{Fault, SceneError};
use serde::de::DeserializeOwned;

/// Reads `text`, which `source` describes, as a `T`.
pub(crate) fn parse<T: DeserializeOwned>(source: &Source, text: &str) -> Result<T, SceneError> {
    toml::from_str(text).map_err(|error| {
        let is_toml = toml::from_str::<toml::Table>(text).is_ok();
        let fault = if is_toml {
            fault_of(error.message())
        } else {
            Fault::Syntax {
                message: error.message().to_owned(),
            }
        };
        let span = error.span().unwrap_or(0..0);
        SceneError::at(source.place(span), fault)
    })
}

/// The fault that a message of the deserialiser stands for.
fn fault_of(message: &str) -> Fault {
    if let Some(rest) = message.strip_prefix("unknown field ") {
        let mut quoted = rest.split('`').skip(1).step_by(2);
        let key = quoted.next().unwrap_or_default();
        let known: Vec<&str> = quoted.collect();
        return Fault::UnknownKey {
            key: key.to_owned(),
            nearest: nearest(key, known.iter().copied()).map(str::to_owned),
            known: known.join(", "),
        };
    }
    let message = message
        .replace("missing field", "missing key")
        .replace("unknown variant", "unknown value")
        .replace("expected f64", "expected a number")
        .replace("expected usize", "expected a whole number, not negative")
        .replace("floating point", "number");
    Fault::Type { message }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_is_recognised_with_its_neighbours() {
        let fault = fault_of("unknown field `mas`, expected one of `name`, `mass`");
        let expected = Fault::UnknownKey {
            key: "mas".into(),
            nearest: Some("mass".into()),
            known: "name, mass".into(),
        };
        assert_eq!(fault, expected);
    }
}
