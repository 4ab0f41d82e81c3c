//! What happens around the substeps: components into columns, and columns back into components.

pub(crate) mod extract;
pub(crate) mod gather;
pub(crate) mod layout;
pub(crate) mod links;
pub(crate) mod scatter;
