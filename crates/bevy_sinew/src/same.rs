//! Conversions between the solver's types and their equivalents in this crate, which Bevy can reflect and use as components. Each pair has the same variants or
//! fields, and both directions are generated from one list.

/// Conversions of an enum with the same variants as another.
macro_rules! same_variants {
    ($own:ident, $other:ty {
        $($variant:ident $({ $($field:ident),* })? $(($value:ident))?),* $(,)?
    }) => {
        impl From<$own> for $other {
            fn from(own: $own) -> Self {
                match own {
                    $($own::$variant $({ $($field),* })? $(($value))? => {
                        Self::$variant $({ $($field),* })? $(($value))?
                    })*
                }
            }
        }

        impl From<$other> for $own {
            fn from(other: $other) -> Self {
                type Other = $other;
                match other {
                    $(Other::$variant $({ $($field),* })? $(($value))? => {
                        Self::$variant $({ $($field),* })? $(($value))?
                    })*
                }
            }
        }
    };
}

/// Conversions of a struct with the same fields as another; `own` and `other` give values for the fields that only one of them has.
macro_rules! same_fields {
    (
        $own:ident, $other:ty { $($field:ident),* $(,)? }
        $(own { $($more:ident: $default:expr),* })?
        $(other { $($rest:ident: $usual:expr),* })?
    ) => {
        impl From<$own> for $other {
            fn from(own: $own) -> Self {
                Self { $($field: own.$field.into(),)* $($($rest: $usual),*)? }
            }
        }

        impl From<$other> for $own {
            fn from(other: $other) -> Self {
                Self { $($field: other.$field.into(),)* $($($more: $default),*)? }
            }
        }
    };
}

pub(crate) use {same_fields, same_variants};
