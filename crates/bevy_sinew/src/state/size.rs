//! The memory that a snapshot takes, for tools that keep many of them.

use bevy::prelude::*;
use bevy::reflect::{PartialReflect, ReflectRef};
use sinew::CachedManifold;

use super::values::Column;
use crate::components::ContactCache;

/// The memory of the values of one type, bytes.
pub(super) fn of(column: &Column) -> usize {
    let (own, may_own_more) = column.values.bytes();
    let numbers = size_of_val(&*column.numbers);
    if !may_own_more {
        return own + numbers;
    }
    let values = (0..column.values.len()).filter_map(|place| column.values.view(place));
    own + numbers + values.map(heap).sum::<usize>()
}

/// The heap memory of a value, bytes, as far as reflection sees it.
fn heap(value: &dyn PartialReflect) -> usize {
    if let Some(ContactCache(cached)) = value.try_downcast_ref::<ContactCache>() {
        return cached.len() * size_of::<CachedManifold>();
    }
    if let Some(text) = value.try_downcast_ref::<String>() {
        return text.len();
    }
    if let Some(name) = value.try_downcast_ref::<Name>() {
        return name.as_str().len();
    }
    match value.reflect_ref() {
        ReflectRef::Struct(value) => value.iter_fields().map(|(_, field)| heap(field)).sum(),
        ReflectRef::TupleStruct(value) => value.iter_fields().map(heap).sum(),
        ReflectRef::Tuple(value) => value.iter_fields().map(heap).sum(),
        ReflectRef::Enum(value) => value.iter_fields().map(|field| heap(field.value())).sum(),
        ReflectRef::List(list) => {
            let Some(first) = list.get(0) else { return 0 };
            let items = list.len() * size_of_val(first);
            // If the first item has no heap memory, none has: lists of entities and of points are long.
            if heap(first) == 0 { items } else { items + list.iter().map(heap).sum::<usize>() }
        }
        _ => 0,
    }
}
