//! A hash of the whole state: FNV-1a, with a mixing step, over every value, traversed by reflection down to its numbers, bit by bit.

use bevy::prelude::*;
use bevy::reflect::{PartialReflect, ReflectRef};

use super::values::{Column, StateRole};
use crate::components::{AnyConstraint, ColliderShape, ContactCache};

/// FNV-1a (Fowler, Noll, Vo), 64 bits: the hash of nothing.
pub(crate) const FNV_START: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a: the hash of a sequence that continues with this word.
pub(crate) fn fnv(hash: u64, word: u64) -> u64 {
    (hash ^ word).wrapping_mul(0x0100_0000_01b3)
}

/// The hash of the values of all types; `orders` is the order of creation of each entity.
pub(super) fn of(orders: &[u64], columns: &[Column]) -> u64 {
    let mut hash = Hash { state: FNV_START, orders };
    // Sorted by name, since the order in which types were registered is irrelevant.
    let mut columns: Vec<&Column> = columns.iter().collect();
    columns.retain(|column| column.kind.is_hashed());
    columns.sort_by(|a, b| a.kind.name().cmp(b.kind.name()));
    for column in columns {
        hash.column(column);
    }
    hash.state
}

struct Hash<'a> {
    state: u64,
    orders: &'a [u64],
}

impl Hash<'_> {
    fn column(&mut self, column: &Column) {
        self.bytes(column.kind.name().as_bytes());
        for (place, &number) in column.numbers.iter().enumerate() {
            let order = self.orders.get(number as usize).copied().unwrap_or_default();
            let is_resource = column.kind.role() == StateRole::Resource;
            // An entity without an order of creation has no place that is the same everywhere.
            if order == 0 && !is_resource {
                continue;
            }
            self.word(order);
            match column.values.view(place) {
                Some(value) => self.value(value),
                None => {
                    column.values.particles(place).iter().for_each(|&entity| self.entity(entity));
                }
            }
        }
    }

    fn word(&mut self, word: u64) {
        self.state = fnv(self.state, word);
        // A product propagates only to higher bits, so the high half is mixed into the low one.
        self.state ^= self.state >> 32;
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        bytes.iter().for_each(|&byte| self.word(byte.into()));
    }

    /// Hashes an entity by its order of creation.
    fn entity(&mut self, entity: Entity) {
        let order = self.orders.get(entity.index_u32() as usize).copied();
        self.word(order.unwrap_or(u64::MAX));
    }

    fn value(&mut self, value: &dyn PartialReflect) {
        match value.reflect_ref() {
            ReflectRef::Opaque(value) => self.leaf(value),
            _ if is_leaf(value) => self.leaf(value),
            ReflectRef::Struct(value) => {
                value.iter_fields().for_each(|(_, field)| self.value(field));
            }
            ReflectRef::TupleStruct(value) => {
                value.iter_fields().for_each(|field| self.value(field));
            }
            ReflectRef::Tuple(value) => value.iter_fields().for_each(|field| self.value(field)),
            ReflectRef::Enum(value) => {
                self.word(value.variant_index() as u64);
                value.iter_fields().for_each(|field| self.value(field.value()));
            }
            ReflectRef::List(value) => {
                self.word(value.len() as u64);
                value.iter().for_each(|item| self.value(item));
            }
            ReflectRef::Array(value) => {
                self.word(value.len() as u64);
                value.iter().for_each(|item| self.value(item));
            }
            // Maps and sets have no order, so the hashes of their items are added.
            ReflectRef::Map(value) => {
                let items = value.iter().map(|(key, value)| {
                    self.of(|hash| {
                        hash.value(key);
                        hash.value(value);
                    })
                });
                let sum = items.fold(value.len() as u64, u64::wrapping_add);
                self.word(sum);
            }
            ReflectRef::Set(value) => {
                let items = value.iter().map(|item| self.of(|hash| hash.value(item)));
                let sum = items.fold(value.len() as u64, u64::wrapping_add);
                self.word(sum);
            }
            #[allow(unreachable_patterns, reason = "functions are reflected in some builds")]
            _ => {}
        }
    }

    /// The hash of an item by itself.
    fn of(&self, add: impl FnOnce(&mut Self)) -> u64 {
        let mut alone = Self { state: FNV_START, orders: self.orders };
        add(&mut alone);
        alone.state
    }

    fn leaf(&mut self, value: &dyn PartialReflect) {
        macro_rules! numbers {
            ($($number:ty => $word:expr;)*) => {$(
                if let Some(&number) = value.try_downcast_ref::<$number>() {
                    let word: fn($number) -> u64 = $word;
                    return self.word(word(number));
                }
            )*};
        }
        numbers! {
            f32 => |x| x.to_bits().into();
            u32 => u64::from;
            bool => u64::from;
            u64 => |x| x;
            f64 => f64::to_bits;
            usize => |x| x as u64;
            i32 => |x| x as u64;
            u8 => u64::from;
            u16 => u64::from;
            i64 => |x| x as u64;
            i16 => |x| x as u64;
            i8 => |x| x as u64;
        }
        if let Some(&entity) = value.try_downcast_ref::<Entity>() {
            self.entity(entity);
        } else if let Some(text) = value.try_downcast_ref::<String>() {
            self.bytes(text.as_bytes());
        } else if let Some(name) = value.try_downcast_ref::<Name>() {
            self.bytes(name.as_str().as_bytes());
        } else if let Some(ColliderShape(shape)) = value.try_downcast_ref::<ColliderShape>() {
            shape.to_words().into_iter().for_each(|word| self.word(word.into()));
        } else if let Some(ContactCache(cached)) = value.try_downcast_ref::<ContactCache>() {
            let words = cached.iter().flat_map(sinew::CachedManifold::to_words);
            words.for_each(|word| self.word(word.into()));
        } else if let Some(any) = value.try_downcast_ref::<AnyConstraint>() {
            any.particles.iter().for_each(|&entity| self.entity(entity));
            self.bytes(format!("{:?}", any.kind).as_bytes());
        } else {
            // Any other type by its reflected hash and its `Debug` output.
            self.word(value.reflect_hash().unwrap_or_default());
            self.bytes(format!("{value:?}").as_bytes());
        }
    }
}

/// Whether reflection does not see the contents of a value, or more than is to be hashed.
fn is_leaf(value: &dyn PartialReflect) -> bool {
    value.try_downcast_ref::<ContactCache>().is_some() || value.try_downcast_ref::<Name>().is_some()
}
