//! The structures in footers and pages of Parquet files, with the types of their fields. A file whose
//! fields have other types is refused: the library reads a value of the declared type, whatever
//! type the file gives, and would read all that follows differently from the check.
//!
//! Source: `parquet.thrift` of Apache Parquet's format 2.12, whose field numbers these are. What is
//! not listed is skipped by the library.

/// The type of a field's value.
#[derive(Clone, Copy)]
pub(super) enum Type {
    Boolean,
    I8,
    I16,
    I32,
    I64,
    Double,
    /// Also Strings.
    Binary,
    List(&'static Type),
    Structure(Fields),
    /// The elements of the schema.
    Schema,
}

/// Number and type of each.
pub(super) type Fields = &'static [(i16, Type)];

use Type::{Binary, Boolean, Double, I8, I16, I32, I64, List, Schema, Structure};

const NOTHING: Type = Structure(&[]);

pub(super) const FILE: Fields = &[
    (1, I32),
    (2, Schema),
    (3, I64),
    (4, List(&Structure(ROW_GROUP))),
    (5, List(&Structure(KEY_VALUE))),
    (6, Binary),
    (7, List(&Structure(&[(1, NOTHING), (2, NOTHING), (3, NOTHING)]))),
    (8, Structure(&[(1, ENCRYPTION), (2, ENCRYPTION)])),
    (9, Binary),
];

pub(super) const SCHEMA_ELEMENT: Fields = &[
    (1, I32),
    (2, I32),
    (3, I32),
    (4, Binary),
    (5, I32),
    (6, I32),
    (7, I32),
    (8, I32),
    (9, I32),
    (10, Structure(LOGICAL_TYPE)),
];

const LOGICAL_TYPE: Fields = &[
    (1, NOTHING),
    (2, NOTHING),
    (3, NOTHING),
    (4, NOTHING),
    (5, Structure(&[(1, I32), (2, I32)])),
    (6, NOTHING),
    (7, TIME),
    (8, TIME),
    (10, Structure(&[(1, I8), (2, Boolean)])),
    (11, NOTHING),
    (12, NOTHING),
    (13, NOTHING),
    (14, NOTHING),
    (15, NOTHING),
    (16, Structure(&[(1, I8)])),
    (17, Structure(&[(1, Binary)])),
    (18, Structure(&[(1, Binary), (2, I32)])),
];

const TIME: Type =
    Structure(&[(1, Boolean), (2, Structure(&[(1, NOTHING), (2, NOTHING), (3, NOTHING)]))]);

const ROW_GROUP: Fields = &[
    (1, List(&Structure(COLUMN_CHUNK))),
    (2, I64),
    (3, I64),
    (4, List(&Structure(&[(1, I32), (2, Boolean), (3, Boolean)]))),
    (5, I64),
    (6, I64),
    (7, I16),
];

const COLUMN_CHUNK: Fields = &[
    (1, Binary),
    (2, I64),
    (3, Structure(COLUMN)),
    (4, I64),
    (5, I32),
    (6, I64),
    (7, I32),
    (8, Structure(&[(1, NOTHING), (2, Structure(&[(1, List(&Binary)), (2, Binary)]))])),
    (9, Binary),
];

const COLUMN: Fields = &[
    (1, I32),
    (2, List(&I32)),
    (3, List(&Binary)),
    (4, I32),
    (5, I64),
    (6, I64),
    (7, I64),
    (8, List(&Structure(KEY_VALUE))),
    (9, I64),
    (10, I64),
    (11, I64),
    (12, Structure(STATISTICS)),
    (13, List(&Structure(&[(1, I32), (2, I32), (3, I32)]))),
    (14, I64),
    (15, I32),
    (16, Structure(&[(1, I64), (2, List(&I64)), (3, List(&I64))])),
    (17, Structure(&[(1, Structure(BOX)), (2, List(&I32))])),
];

const STATISTICS: Fields = &[
    (1, Binary),
    (2, Binary),
    (3, I64),
    (4, I64),
    (5, Binary),
    (6, Binary),
    (7, Boolean),
    (8, Boolean),
    (9, I64),
];

const BOX: Fields = &[
    (1, Double),
    (2, Double),
    (3, Double),
    (4, Double),
    (5, Double),
    (6, Double),
    (7, Double),
    (8, Double),
];

const KEY_VALUE: Fields = &[(1, Binary), (2, Binary)];

const ENCRYPTION: Type = Structure(&[(1, Binary), (2, Binary), (3, Boolean)]);

pub(super) const PAGE: Fields = &[
    (1, I32),
    (2, I32),
    (3, I32),
    (4, I32),
    (5, Structure(&[(1, I32), (2, I32), (3, I32), (4, I32), (5, Structure(STATISTICS))])),
    (6, NOTHING),
    (7, Structure(&[(1, I32), (2, I32), (3, Boolean)])),
    (8, Structure(PAGE_2)),
];

const PAGE_2: Fields = &[
    (1, I32),
    (2, I32),
    (3, I32),
    (4, I32),
    (5, I32),
    (6, I32),
    (7, Boolean),
    (8, Structure(STATISTICS)),
];
