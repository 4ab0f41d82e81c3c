//! Types that stand for the solver's, which Bevy can neither reflect nor make components of: with the same variants or fields, both ways from one list.

/// An enum with the variants of another.
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

/// A struct with the fields of another; and what fields of either are that the other one does not have, where it is made from that.
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
