//! The shape of a component's memory: names and order of its fields and their types, as text.
//!
//! Saved bytes do not say what they mean. Another version of a component may have the same
//! variables, so the same GUID, and a different memory; its bytes would be misread. So the shape of
//! the default memory is saved with them, as a fingerprint.

use std::fmt::{self, Display, Write as _};

use serde::ser::{self, Serialize};
use sha2::{Digest, Sha256};

/// Length of a fingerprint in bytes.
pub(crate) const LENGTH: usize = 8;

/// What distinguishes the shape of a value from others.
pub(crate) fn fingerprint(value: &impl Serialize) -> Result<[u8; LENGTH], String> {
    let mut shape = Shape(String::new());
    value.serialize(&mut shape).map_err(|flaw| flaw.0)?;
    let mut fingerprint = [0; LENGTH];
    for (to, from) in fingerprint.iter_mut().zip(Sha256::digest(shape.0)) {
        *to = from;
    }
    Ok(fingerprint)
}

struct Shape(String);

/// Why a value cannot be serialized, in the words of its type.
#[derive(Debug)]
struct Flaw(String);

impl Display for Flaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Flaw {}

impl ser::Error for Flaw {
    fn custom<T: Display>(text: T) -> Self {
        Self(text.to_string())
    }
}

type Outcome<T = ()> = Result<T, Flaw>;

impl Shape {
    fn note(&mut self, text: &str) -> Outcome {
        write!(self.0, "{text} ").map_err(ser::Error::custom)
    }

    fn open(&mut self, name: &str) -> Outcome<&mut Self> {
        self.note(name)?;
        self.note("{")?;
        Ok(self)
    }

    fn close(&mut self) -> Outcome {
        self.note("}")
    }
}

/// Values of one type have one shape.
macro_rules! leaves {
    ($($method:ident $kind:ty),*) => {$(
        fn $method(self, _: $kind) -> Outcome {
            self.note(stringify!($kind))
        }
    )*};
}

impl<'a> ser::Serializer for &'a mut Shape {
    type Ok = ();
    type Error = Flaw;
    type SerializeSeq = &'a mut Shape;
    type SerializeTuple = &'a mut Shape;
    type SerializeTupleStruct = &'a mut Shape;
    type SerializeTupleVariant = &'a mut Shape;
    type SerializeMap = &'a mut Shape;
    type SerializeStruct = &'a mut Shape;
    type SerializeStructVariant = &'a mut Shape;

    leaves!(
        serialize_bool bool, serialize_char char, serialize_str &str, serialize_bytes &[u8],
        serialize_i8 i8, serialize_i16 i16, serialize_i32 i32, serialize_i64 i64, serialize_i128 i128,
        serialize_u8 u8, serialize_u16 u16, serialize_u32 u32, serialize_u64 u64, serialize_u128 u128,
        serialize_f32 f32, serialize_f64 f64
    );

    fn serialize_none(self) -> Outcome {
        self.note("none")
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Outcome {
        self.note("some")?;
        value.serialize(self)
    }

    fn serialize_unit(self) -> Outcome {
        self.note("()")
    }

    fn serialize_unit_struct(self, name: &'static str) -> Outcome {
        self.note(name)
    }

    fn serialize_unit_variant(self, name: &'static str, _: u32, own: &'static str) -> Outcome {
        self.note(name)?;
        self.note(own)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        value: &T,
    ) -> Outcome {
        self.note(name)?;
        value.serialize(self)
    }

    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        name: &'static str,
        _: u32,
        own: &'static str,
        value: &T,
    ) -> Outcome {
        self.note(name)?;
        self.note(own)?;
        value.serialize(self)
    }

    fn serialize_seq(self, _: Option<usize>) -> Outcome<Self> {
        self.open("seq")
    }

    fn serialize_tuple(self, _: usize) -> Outcome<Self> {
        self.open("tuple")
    }

    fn serialize_tuple_struct(self, name: &'static str, _: usize) -> Outcome<Self> {
        self.open(name)
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        own: &'static str,
        _: usize,
    ) -> Outcome<Self> {
        self.open(own)
    }

    fn serialize_map(self, _: Option<usize>) -> Outcome<Self> {
        self.open("map")
    }

    fn serialize_struct(self, name: &'static str, _: usize) -> Outcome<Self> {
        self.open(name)
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        own: &'static str,
        _: usize,
    ) -> Outcome<Self> {
        self.open(own)
    }
}

/// A value with unnamed elements.
macro_rules! elements {
    ($($what:ident $method:ident),*) => {$(
        impl ser::$what for &mut Shape {
            type Ok = ();
            type Error = Flaw;

            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Outcome {
                value.serialize(&mut **self)
            }

            fn end(self) -> Outcome {
                self.close()
            }
        }
    )*};
}

elements!(
    SerializeSeq serialize_element, SerializeTuple serialize_element,
    SerializeTupleStruct serialize_field, SerializeTupleVariant serialize_field
);

/// A value with named fields.
macro_rules! fields {
    ($($what:ident),*) => {$(
        impl ser::$what for &mut Shape {
            type Ok = ();
            type Error = Flaw;

            fn serialize_field<T: Serialize + ?Sized>(
                &mut self,
                name: &'static str,
                value: &T,
            ) -> Outcome {
                self.note(name)?;
                value.serialize(&mut **self)
            }

            fn end(self) -> Outcome {
                self.close()
            }
        }
    )*};
}

fields!(SerializeStruct, SerializeStructVariant);

impl ser::SerializeMap for &mut Shape {
    type Ok = ();
    type Error = Flaw;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Outcome {
        key.serialize(&mut **self)
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Outcome {
        value.serialize(&mut **self)
    }

    fn end(self) -> Outcome {
        self.close()
    }
}

#[cfg(test)]
mod tests {
    use super::fingerprint;
    use serde::Serialize;

    mod other {
        /// The same number of bytes as its namesake, with the fields swapped.
        #[derive(Default, serde::Serialize)]
        pub(super) struct Memory {
            pub(super) speed: f64,
            pub(super) depth: f64,
        }
    }

    #[derive(Default, Serialize)]
    struct Memory {
        depth: f64,
        speed: f64,
    }

    #[test]
    fn the_fingerprint_is_of_the_shape_and_not_of_the_values() {
        let own = fingerprint(&Memory::default()).unwrap();
        assert_eq!(fingerprint(&Memory { depth: 1.0, speed: 2.0 }).unwrap(), own);
        assert_ne!(fingerprint(&other::Memory::default()).unwrap(), own);
        assert_ne!(fingerprint(&(0_u64, 0.0)).unwrap(), fingerprint(&(0.0, 0_u64)).unwrap());
        assert_ne!(fingerprint(&[0.0; 2]).unwrap(), fingerprint(&[0.0; 3]).unwrap());
        assert_ne!(fingerprint(&Some(1.0)).unwrap(), fingerprint(&None::<f64>).unwrap());
    }
}
