//! Snapshots as files: RON, which can be read and compared, and compact bytes; both restore the same bits.
//!
//! A file has a tag, a version, the number of entities, a column for each type (its name, the indices of its entities, its values by reflection) and the
//! [hash](SinewSnapshot::hash) of everything. Entities are identified by their index in the snapshot. Types that are opaque to reflection are written as
//! integers: the shapes of colliders by what they were made of, cached contacts by their numbers. Reading does not access the simulation: an invalid file
//! changes nothing.

use core::any::TypeId;
use core::fmt::{self, Formatter};

use bevy::prelude::*;
use bevy::reflect::serde::{
    ReflectDeserializerProcessor, ReflectSerializerProcessor, TypedReflectDeserializer,
    TypedReflectSerializer,
};
use bevy::reflect::{PartialReflect, TypeRegistration, TypeRegistry};
use serde::de::{DeserializeSeed, Error as _, SeqAccess, Visitor};
use serde::ser::{Error as _, SerializeSeq, SerializeTuple};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sinew::{CachedManifold, Shape};

use super::hash::{FNV_START, fnv};
use super::snapshot::SinewSnapshot;
use super::types::StateTypes;
use super::values::{Column, StateKind, StateRole, Values};
use crate::components::{AnyConstraint, ColliderShape, ContactCache, CreationOrder};

/// The tag at the beginning of a file.
const TAG: &str = "bevy_sinew state";
/// The first bytes of a binary file.
const MAGIC: [u8; 4] = *b"SNEW";
/// The version of the format. Files of another version are refused.
const VERSION: u32 = 1;
/// The index that stands for no entity.
const NO_ENTITY: u32 = u32::MAX;

/// Why a snapshot cannot be written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SaveFault {
    /// A custom constraint is not reflected: call [`register_state`](crate::RegisterState::register_state) for it.
    #[error("{0} is not reflected: register it with register_state")]
    NotReflected(String),
    /// Reflection cannot write a value: an [`AnyConstraint`], or a field of a custom component.
    #[error("it cannot be written: {0}")]
    Unwritable(String),
}

/// Why a file is refused. Nothing has changed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadFault {
    /// It is not a snapshot.
    #[error("it is not a snapshot of bevy_sinew")]
    Foreign,
    /// It has another version of the format.
    #[error("it has version {0} of the format, and only version {VERSION} can be read")]
    Version(u32),
    /// It has values of a type that is not registered as state in this app, or is not reflected there.
    #[error("{0} is not registered as state in this app")]
    Unregistered(String),
    /// It is truncated or corrupted.
    #[error("it is truncated or corrupted: {0}")]
    Broken(String),
    /// Its contents differ from what was written.
    #[error("its contents differ from what was written: the hash does not match")]
    Hash,
}

impl SinewSnapshot {
    /// Writes the snapshot as text, in RON (Rusty Object Notation). Floats are restored bit for bit.
    ///
    /// Types that a game registered as unsaved, and handles, are left out; everything else is written. `world` must have the same types registered: it is
    /// usually the world of the snapshot.
    ///
    /// # Errors
    /// A constraint that is not reflected, or a value that reflection cannot write.
    pub fn to_ron(&self, world: &World) -> Result<String, SaveFault> {
        self.write(world, |file| {
            let options = ron::Options::default().without_recursion_limit();
            let pretty = ron::ser::PrettyConfig::new().depth_limit(3);
            options.to_string_pretty(file, pretty).map_err(|fault| fault.to_string())
        })
    }

    /// Writes the snapshot as bytes, about an eighth of the size of the text.
    ///
    /// # Errors
    /// As [`to_ron`](Self::to_ron).
    pub fn to_bytes(&self, world: &World) -> Result<Vec<u8>, SaveFault> {
        let payload = self
            .write(world, |file| postcard::to_allocvec(file).map_err(|fault| fault.to_string()))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(VERSION.to_le_bytes());
        bytes.extend(checksum(&payload).to_le_bytes());
        bytes.extend(payload);
        Ok(bytes)
    }

    /// Reads what [`to_ron`](Self::to_ron) wrote. `world` must be one in which the same types are registered.
    ///
    /// # Errors
    /// Text that is not a snapshot, has another version, is truncated or changed, or has a type that is not registered.
    pub fn from_ron(text: &str, world: &World) -> Result<Self, LoadFault> {
        Self::read(world, text.len(), |file| {
            let options = ron::Options::default().without_recursion_limit();
            options.from_str_seed(text, file).map_err(|fault| fault.to_string())
        })
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote. `world` must be one in which the same types are registered.
    ///
    /// # Errors
    /// As [`from_ron`](Self::from_ron).
    pub fn from_bytes(bytes: &[u8], world: &World) -> Result<Self, LoadFault> {
        let (magic, rest) = bytes.split_first_chunk::<4>().ok_or(LoadFault::Foreign)?;
        if *magic != MAGIC {
            return Err(LoadFault::Foreign);
        }
        let short = || LoadFault::Broken("it ends too early".into());
        let (version, rest) = rest.split_first_chunk::<4>().ok_or_else(short)?;
        let version = u32::from_le_bytes(*version);
        if version != VERSION {
            return Err(LoadFault::Version(version));
        }
        let (sum, payload) = rest.split_first_chunk::<8>().ok_or_else(short)?;
        if u64::from_le_bytes(*sum) != checksum(payload) {
            return Err(LoadFault::Hash);
        }
        Self::read(world, payload.len(), |file| {
            let mut bytes = postcard::Deserializer::from_bytes(payload);
            let read = file.deserialize(&mut bytes).map_err(|fault| fault.to_string())?;
            let rest = bytes.finalize().map_err(|fault| fault.to_string())?;
            if rest.is_empty() { Ok(read) } else { Err("there is data after its end".into()) }
        })
    }

    fn write<T>(
        &self,
        world: &World,
        write: impl FnOnce(&FileOut) -> Result<T, String>,
    ) -> Result<T, SaveFault> {
        let registry = world.get_resource::<AppTypeRegistry>().cloned().unwrap_or_default();
        let registry = registry.read();
        let mut columns = Vec::new();
        for column in &self.columns {
            match (column.kind.role(), column.kind.is_reflected()) {
                (StateRole::Local, _) | (StateRole::Carried, false) => {}
                (_, true) => columns.push(column),
                (_, false) => {
                    return Err(SaveFault::NotReflected(column.kind.name().into()));
                }
            }
        }
        let file = FileOut { snapshot: self, columns, registry: &registry };
        write(&file).map_err(SaveFault::Unwritable)
    }

    fn read(
        world: &World,
        most: usize,
        read: impl FnOnce(FileIn) -> Result<(Self, u64), String>,
    ) -> Result<Self, LoadFault> {
        let registry = world.get_resource::<AppTypeRegistry>().cloned().unwrap_or_default();
        let registry = registry.read();
        let none = StateTypes::default();
        let types = world.get_resource::<StateTypes>().unwrap_or(&none);
        let mut fault = None;
        let file = FileIn { types, registry: &registry, most, fault: &mut fault };
        match (read(file), fault) {
            (_, Some(fault)) => Err(fault),
            (Err(broken), None) => Err(LoadFault::Broken(broken)),
            (Ok((snapshot, hash)), None) if snapshot.hash() == hash => Ok(snapshot),
            (Ok(_), None) => Err(LoadFault::Hash),
        }
    }
}

/// FNV-1a hash of bytes.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(FNV_START, |hash, &byte| fnv(hash, byte.into()))
}

/// A snapshot being written.
struct FileOut<'a> {
    snapshot: &'a SinewSnapshot,
    columns: Vec<&'a Column>,
    registry: &'a TypeRegistry,
}

impl Serialize for FileOut<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let columns = self.columns.iter().map(|&column| ColumnOut(column, self.registry));
        let mut file = serializer.serialize_tuple(5)?;
        file.serialize_element(TAG)?;
        file.serialize_element(&VERSION)?;
        file.serialize_element(&(self.snapshot.entities.len() as u32))?;
        file.serialize_element(&columns.collect::<Vec<_>>())?;
        file.serialize_element(&self.snapshot.hash())?;
        file.end()
    }
}

struct ColumnOut<'a>(&'a Column, &'a TypeRegistry);

impl Serialize for ColumnOut<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(column, registry) = *self;
        let mut tuple = serializer.serialize_tuple(3)?;
        tuple.serialize_element(column.kind.name())?;
        tuple.serialize_element(&*column.numbers)?;
        tuple.serialize_element(&ValuesOut(&*column.values, registry))?;
        tuple.end()
    }
}

struct ValuesOut<'a>(&'a dyn Values, &'a TypeRegistry);

impl Serialize for ValuesOut<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self(values, registry) = *self;
        let mut list = serializer.serialize_seq(Some(values.len()))?;
        for value in (0..values.len()).filter_map(|place| values.view(place)) {
            list.serialize_element(&TypedReflectSerializer::with_processor(
                value, registry, &Leaves,
            ))?;
        }
        list.end()
    }
}

/// A snapshot being read.
struct FileIn<'a> {
    types: &'a StateTypes,
    registry: &'a TypeRegistry,
    /// The maximum number of entities: the size of the file, in bytes.
    most: usize,
    /// The error, if it is not one of syntax.
    fault: &'a mut Option<LoadFault>,
}

impl<'de> DeserializeSeed<'de> for FileIn<'_> {
    type Value = (SinewSnapshot, u64);

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_tuple(5, self)
    }
}

/// The next element of a sequence, or an error if it is missing.
fn next<'de, T: Deserialize<'de>, A: SeqAccess<'de>>(parts: &mut A) -> Result<T, A::Error> {
    parts.next_element()?.ok_or_else(|| A::Error::custom("it ends too early"))
}

impl<'de> Visitor<'de> for FileIn<'_> {
    type Value = (SinewSnapshot, u64);

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str("the state of a simulation")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Self::Value, A::Error> {
        let Self { types, registry, most, fault } = self;
        let refuse = |fault: &mut Option<LoadFault>, why: LoadFault| {
            let error = A::Error::custom(&why);
            *fault = Some(why);
            Err(error)
        };
        if next::<String, A>(&mut parts).ok().as_deref() != Some(TAG) {
            return refuse(fault, LoadFault::Foreign);
        }
        let version: u32 = next(&mut parts)?;
        if version != VERSION {
            return refuse(fault, LoadFault::Version(version));
        }
        let entities: u32 = next(&mut parts)?;
        if entities as usize > most {
            return Err(A::Error::custom("it has more entities than bytes"));
        }
        let columns = ColumnsIn { types, registry, entities, fault };
        let columns = parts.next_element_seed(columns)?;
        let columns = columns.ok_or_else(|| A::Error::custom("it has no values"))?;
        let hash = next(&mut parts)?;
        let numbers = (0..entities).filter_map(Entity::from_raw_u32).collect();
        let mut orders = vec![0; entities as usize];
        for column in columns.iter().filter(|c| c.kind.id() == TypeId::of::<CreationOrder>()) {
            for (place, &number) in column.numbers.iter().enumerate() {
                let order = column.values.view(place);
                let order = order.and_then(|order| order.try_downcast_ref::<CreationOrder>());
                orders[number as usize] = order.map_or(0, |order| order.0);
            }
        }
        Ok((SinewSnapshot { world: None, entities: numbers, orders, columns }, hash))
    }
}

struct ColumnsIn<'a> {
    types: &'a StateTypes,
    registry: &'a TypeRegistry,
    entities: u32,
    fault: &'a mut Option<LoadFault>,
}

impl<'de> DeserializeSeed<'de> for ColumnsIn<'_> {
    type Value = Vec<Column>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for ColumnsIn<'_> {
    type Value = Vec<Column>;

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str("the values of each type")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Self::Value, A::Error> {
        let Self { types, registry, entities, fault } = self;
        let mut columns: Vec<Column> = Vec::new();
        while let Some(column) =
            parts.next_element_seed(ColumnIn { types, registry, entities, fault: &mut *fault })?
        {
            if columns.iter().any(|known| known.kind.id() == column.kind.id()) {
                return Err(A::Error::custom("a type occurs twice"));
            }
            columns.push(column);
        }
        Ok(columns)
    }
}

struct ColumnIn<'a> {
    types: &'a StateTypes,
    registry: &'a TypeRegistry,
    entities: u32,
    fault: &'a mut Option<LoadFault>,
}

impl<'de> DeserializeSeed<'de> for ColumnIn<'_> {
    type Value = Column;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_tuple(3, self)
    }
}

impl<'de> Visitor<'de> for ColumnIn<'_> {
    type Value = Column;

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str("a type, the numbers of its entities, and its values")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Self::Value, A::Error> {
        let Self { types, registry, entities, fault } = self;
        let name: String = next(&mut parts)?;
        let kind = types.kinds.iter().find(|kind| kind.name() == name && kind.is_reflected());
        let known = kind.and_then(|kind| Some((kind, registry.get(kind.id())?)));
        let Some((kind, registration)) = known else {
            *fault = Some(LoadFault::Unregistered(name));
            return Err(A::Error::custom("a type is not registered"));
        };
        let numbers: Vec<u32> = next(&mut parts)?;
        let ascending = numbers.is_sorted_by(|a, b| a < b);
        let is_resource = kind.role() == StateRole::Resource;
        let valid = match is_resource {
            true => numbers == [0],
            false => ascending && numbers.last().is_none_or(|&last| last < entities),
        };
        if !valid {
            return Err(A::Error::custom("an entity index is out of range, or occurs twice"));
        }
        let values = ValuesIn { kind: &**kind, registration, registry };
        let values = parts.next_element_seed(values)?;
        let values = values.ok_or_else(|| A::Error::custom("values are missing"))?;
        if values.len() != numbers.len() {
            return Err(A::Error::custom("there are more or fewer values than entities"));
        }
        Ok(Column { kind: kind.clone(), numbers: numbers.into(), values: values.into() })
    }
}

struct ValuesIn<'a> {
    kind: &'a dyn StateKind,
    registration: &'a TypeRegistration,
    registry: &'a TypeRegistry,
}

impl<'de> DeserializeSeed<'de> for ValuesIn<'_> {
    type Value = Box<dyn Values>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for ValuesIn<'_> {
    type Value = Box<dyn Values>;

    fn expecting(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "values of {}", self.kind.name())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<Self::Value, A::Error> {
        let Self { kind, registration, registry } = self;
        let mut values = kind.none();
        let mut leaves = Leaves;
        loop {
            let seed =
                TypedReflectDeserializer::with_processor(registration, registry, &mut leaves);
            let Some(value) = parts.next_element_seed(seed)? else { return Ok(values) };
            if !values.push(&*value) {
                return Err(A::Error::custom("a value is not of its type"));
            }
        }
    }
}

/// Values that are written and read differently from their reflection.
struct Leaves;

impl ReflectSerializerProcessor for Leaves {
    fn try_serialize<S: Serializer>(
        &self,
        value: &dyn PartialReflect,
        _: &TypeRegistry,
        serializer: S,
    ) -> Result<Result<S::Ok, S>, S::Error> {
        Ok(Ok(if let Some(entity) = value.try_downcast_ref::<Entity>() {
            let is_placeholder = *entity == Entity::PLACEHOLDER;
            serializer.serialize_u32(if is_placeholder { NO_ENTITY } else { entity.index_u32() })?
        } else if let Some(ColliderShape(shape)) = value.try_downcast_ref::<ColliderShape>() {
            shape.to_words().serialize(serializer)?
        } else if let Some(ContactCache(cached)) = value.try_downcast_ref::<ContactCache>() {
            let words: Vec<_> = cached.iter().map(CachedManifold::to_words).collect();
            words.serialize(serializer)?
        } else if let Some(name) = value.try_downcast_ref::<Name>() {
            serializer.serialize_str(name.as_str())?
        } else if value.try_downcast_ref::<AnyConstraint>().is_some() {
            return Err(S::Error::custom("an AnyConstraint is opaque to reflection"));
        } else {
            return Ok(Err(serializer));
        }))
    }
}

impl ReflectDeserializerProcessor for Leaves {
    fn try_deserialize<'de, D: Deserializer<'de>>(
        &mut self,
        registration: &TypeRegistration,
        _: &TypeRegistry,
        deserializer: D,
    ) -> Result<Result<Box<dyn PartialReflect>, D>, D::Error> {
        let id = registration.type_id();
        let made: Box<dyn PartialReflect> = if id == TypeId::of::<Entity>() {
            let number =
                Some(u32::deserialize(deserializer)?).filter(|&number| number != NO_ENTITY);
            Box::new(number.and_then(Entity::from_raw_u32).unwrap_or(Entity::PLACEHOLDER))
        } else if id == TypeId::of::<ColliderShape>() {
            let words = Vec::<u32>::deserialize(deserializer)?;
            let shape = Shape::from_words(&words);
            Box::new(ColliderShape(shape.ok_or_else(|| D::Error::custom("a shape is invalid"))?))
        } else if id == TypeId::of::<ContactCache>() {
            let words = Vec::<Vec<u32>>::deserialize(deserializer)?;
            let cached = words.iter().map(|words| CachedManifold::from_words(words));
            let cached = cached.collect::<Option<Vec<_>>>();
            Box::new(ContactCache(
                cached.ok_or_else(|| D::Error::custom("a cached contact is invalid"))?,
            ))
        } else if id == TypeId::of::<Name>() {
            Box::new(Name::new(String::deserialize(deserializer)?))
        } else {
            return Ok(Err(deserializer));
        };
        Ok(Ok(made))
    }
}
