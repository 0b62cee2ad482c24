//! Parquet files that no tool would write, each refused with the reason, in the memory and time of
//! all hostile files.

use super::Workspace;

/// Types of Thrift's compact protocol.
const I32: u8 = 5;
const I64: u8 = 6;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const STRUCTURE: u8 = 12;

/// Types of columns.
const DOUBLE: i64 = 5;
const STRING: i64 = 6;
/// Encodings of pages.
const PLAIN: i64 = 0;
const PREFIXES: i64 = 7;
const DICTIONARY: i64 = 8;

fn unsigned(mut number: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while number > 127 {
        bytes.push(number as u8 | 128);
        number >>= 7;
    }
    bytes.push(number as u8);
    bytes
}

fn integer(number: i64) -> Vec<u8> {
    unsigned(((number << 1) ^ (number >> 63)) as u64)
}

fn binary(bytes: &[u8]) -> Vec<u8> {
    [&unsigned(bytes.len() as u64), bytes].concat()
}

fn list(kind: u8, count: usize, items: &[Vec<u8>]) -> Vec<u8> {
    [&[0xf0 | kind][..], &unsigned(count as u64), &items.concat()].concat()
}

/// Fields with their numbers, which are less than 16 apart.
fn structure(fields: &[(u8, u8, Vec<u8>)]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut last = 0;
    for (number, kind, value) in fields {
        bytes.push((number - last) << 4 | kind);
        bytes.extend(value);
        last = *number;
    }
    bytes.push(0);
    bytes
}

/// An element of the schema.
fn element(name: &str, kind: Option<i64>, children: Option<i64>) -> Vec<u8> {
    let mut fields: Vec<_> = kind.map(|kind| (1, I32, integer(kind))).into_iter().collect();
    fields.extend([(3, I32, integer(0)), (4, BINARY, binary(name.as_bytes()))]);
    fields.extend(children.map(|children| (5, I32, integer(children))));
    structure(&fields)
}

fn page(
    is_dictionary: bool,
    values: usize,
    encoding: i64,
    unpacked: usize,
    body: &[u8],
) -> Vec<u8> {
    let (values, encoding) = ((1, I32, integer(values as i64)), (2, I32, integer(encoding)));
    let mut fields = vec![(1, I32, integer(if is_dictionary { 2 } else { 0 }))];
    fields.extend([(2, I32, integer(unpacked as i64)), (3, I32, integer(body.len() as i64))]);
    fields.push(match is_dictionary {
        true => (7, STRUCTURE, structure(&[values, encoding])),
        false => {
            let levels = [(3, I32, integer(3)), (4, I32, integer(3))];
            (5, STRUCTURE, structure(&[&[values, encoding][..], &levels].concat()))
        }
    });
    [structure(&fields), body.to_vec()].concat()
}

/// So many times the first value of a dictionary.
fn run(rows: usize) -> Vec<u8> {
    [&[1][..], &unsigned((rows as u64) << 1), &[0]].concat()
}

/// The column `time`, always 1.
fn times(rows: usize) -> [Vec<u8>; 2] {
    let run = run(rows);
    [page(true, 1, PLAIN, 8, &1_f64.to_le_bytes()), page(false, rows, DICTIONARY, run.len(), &run)]
}

/// Type, whether it is compressed by Snappy, and pages; the first of two is a dictionary. Without
/// pages it has those of the column before.
type Column = (i64, bool, Vec<Vec<u8>>);

/// A file with one group of rows.
fn file(rows: usize, columns: &[Column]) -> Vec<u8> {
    let mut bytes = b"PAR1".to_vec();
    let mut schema = vec![element("schema", None, Some(columns.len() as i64))];
    let (mut chunks, mut start) = (Vec::new(), 0);
    for (place, (kind, compressed, pages)) in columns.iter().enumerate() {
        let name = if place == 0 { "time".to_owned() } else { format!("c{place}") };
        schema.push(element(&name, Some(*kind), None));
        if !pages.is_empty() {
            start = bytes.len();
            bytes.extend(pages.concat());
        }
        let data = start + if pages.len() > 1 { pages[0].len() } else { 0 };
        let size = integer((bytes.len() - start) as i64);
        let mut fields = vec![
            (1, I32, integer(*kind)),
            (2, LIST, list(I32, 1, &[integer(PLAIN)])),
            (3, LIST, list(BINARY, 1, &[binary(name.as_bytes())])),
            (4, I32, integer(i64::from(*compressed))),
            (5, I64, integer(rows as i64)),
            (6, I64, size.clone()),
            (7, I64, size),
            (9, I64, integer(data as i64)),
        ];
        fields.extend((pages.len() > 1).then(|| (11, I64, integer(start as i64))));
        let chunk = [(2, I64, integer(0)), (3, STRUCTURE, structure(&fields))];
        chunks.push(structure(&chunk));
    }
    let group = structure(&[
        (1, LIST, list(STRUCTURE, chunks.len(), &chunks)),
        (2, I64, integer(1)),
        (3, I64, integer(rows as i64)),
    ]);
    ended(bytes, &schema, &[group], &[])
}

/// A file that ends with this footer.
fn ended(
    mut bytes: Vec<u8>,
    schema: &[Vec<u8>],
    groups: &[Vec<u8>],
    more: &[(u8, u8, Vec<u8>)],
) -> Vec<u8> {
    let fields = [
        (1, I32, integer(1)),
        (2, LIST, list(STRUCTURE, schema.len(), schema)),
        (3, I64, integer(0)),
        (4, LIST, list(STRUCTURE, groups.len(), groups)),
    ];
    let footer = structure(&[&fields[..], more].concat());
    bytes.extend(&footer);
    bytes.extend((footer.len() as u32).to_le_bytes());
    bytes.extend(b"PAR1");
    bytes
}

/// Snappy: some bytes, then equal ones, three bytes for each 64 of them.
fn snappy(first: &[u8], equal: usize) -> Vec<u8> {
    let mut bytes = unsigned((first.len() + equal) as u64);
    bytes.push(((first.len() - 1) << 2) as u8);
    bytes.extend(first);
    bytes.extend((0..equal / 64).flat_map(|_| [63 << 2 | 2, 1, 0]));
    bytes
}

/// A sequence of equal integers, in blocks of 128 with differences of no bits, after another one.
fn equal(first: i64, others: i64, count: usize) -> Vec<u8> {
    let mut bytes = [unsigned(128), unsigned(4), unsigned(count as u64), integer(first)].concat();
    for block in 0..(count - 1).div_ceil(128) {
        let difference = if block == 0 { others - first } else { 0 };
        bytes.extend(integer(difference.min(0)));
        bytes.extend(if difference == 0 { [0; 4] } else { [32; 4] });
        if difference != 0 {
            // The least of the differences is added to all.
            let (own, rest) = (difference.max(0) as u32, -difference.min(0) as u32);
            bytes.extend(own.to_le_bytes());
            bytes.extend((1..128).flat_map(|_| rest.to_le_bytes()));
        }
    }
    bytes
}

/// Strings that each begin with all of the one before, and add nothing.
fn same_prefixes(length: usize, count: usize) -> Vec<u8> {
    let text = vec![b'a'; length];
    let lengths = [equal(0, length as i64, count), equal(length as i64, 0, count)];
    let body = [lengths.concat(), text].concat();
    page(false, count, PREFIXES, body.len(), &body)
}

#[test]
fn the_files_of_these_tests_are_good_but_for_one_thing() {
    let workspace = Workspace::new();
    let text = page(true, 1, PLAIN, 69, &snappy(&[65, 0, 0, 0, b'a'], 64));
    let run = page(false, 1000, DICTIONARY, 4, &snappy(&run(1000), 0));
    let columns = [
        (DOUBLE, false, times(1000).to_vec()),
        (STRING, true, vec![text, run]),
        (STRING, false, vec![same_prefixes(5, 1000)]),
    ];
    let (code, shown) = workspace.run("verify r.parquet", "r.parquet", &file(1000, &columns));
    assert_eq!(code, 0, "{shown}");
}

#[test]
fn results_that_claim_more_than_they_are() {
    let workspace = Workspace::new();
    let time = |rows| (DOUBLE, false, times(rows).to_vec());
    // 2 MB that stand for 1.9 GB of numbers.
    let many = 120_000_000;
    let dictionary = page(true, 250_000, PLAIN, 2_000_000, &vec![0; 2_000_000]);
    let [_, run_of_many] = times(many);
    let numbers = file(many, &[time(many), (DOUBLE, false, vec![dictionary, run_of_many])]);
    // A String of 30 MB in each of 2,000,000 rows.
    let (length, rows) = (64 * 470_000, 2_000_000);
    let text = [&(length as u32 + 1).to_le_bytes()[..], b"a"].concat();
    let text = page(true, 1, PLAIN, length + 5, &snappy(&text, length));
    let run = page(false, rows, DICTIONARY, run(rows).len(), &snappy(&run(rows), 0));
    let strings = file(rows, &[time(rows), (STRING, true, vec![text, run])]);
    let prefixes =
        file(20_000, &[time(20_000), (STRING, false, vec![same_prefixes(500_000, 20_000)])]);
    let unpacked = page(false, 3, PLAIN, i32::MAX as usize, &vec![0; 2_200_000]);
    let unpacked = file(3, &[time(3), (DOUBLE, true, vec![unpacked])]);
    // Columns within columns: the tree of columns is built by recursion.
    let mut schema = vec![element("schema", None, Some(2)), element("time", Some(DOUBLE), None)];
    schema.extend(vec![element("g", None, Some(1)); 300_000]);
    schema.push(element("x", Some(DOUBLE), None));
    let deep = ended(b"PAR1".to_vec(), &schema, &[], &[]);
    let wide = vec![element("g", None, Some(i64::from(i32::MAX))); 100];
    let wide = ended(b"PAR1".to_vec(), &wide, &[], &[]);
    // A list of 2^31 Booleans, which take no bytes where they are skipped.
    let schema = [element("schema", None, Some(1)), element("time", Some(DOUBLE), None)];
    let booleans = list(1, i32::MAX as usize, &[]);
    let more: Vec<_> = (10..100).map(|number| (number, LIST, booleans.clone())).collect();
    let skipped = ended(b"PAR1".to_vec(), &schema, &[], &more);
    // Fields of other types, or numbers that become others in 16 bits: the library would take the
    // bytes for something else.
    let other = ended(b"PAR1".to_vec(), &schema, &[], &[(5, BINARY, binary(&[0xfc]))]);
    let columns = [element("schema", None, None), element("time", Some(DOUBLE), None)];
    let mut longer = columns[0].clone();
    longer.pop();
    longer.extend([vec![I32], integer(65_536 + 5), integer(1), vec![0]].concat());
    let longer = ended(b"PAR1".to_vec(), &[longer, columns[1].clone()], &[], &[]);
    // 20,000 columns that all are the same 200,000 pages.
    let pages = page(false, 0, PLAIN, 0, &[]).repeat(200_000);
    let mut columns: Vec<Column> = vec![(DOUBLE, false, vec![pages])];
    columns.resize(20_000, (DOUBLE, false, Vec::new()));
    let shared = file(0, &columns);
    for (bytes, part) in [
        (&numbers, "claim to hold 120000000 rows"),
        (&strings, "Strings are too long"),
        (&prefixes, "Strings are too long"),
        (&unpacked, "claims to unpack to 2147483647"),
        (&deep, "columns within columns"),
        (&wide, "columns within columns"),
        (&skipped, "header in it cannot be read"),
        (&other, "header in it cannot be read"),
        (&longer, "header in it cannot be read"),
        (&shared, "columns share bytes"),
    ] {
        let (code, shown) = workspace.run("verify r.parquet", "r.parquet", bytes);
        assert_eq!(code, 3, "{part}: {}", &shown[..shown.len().min(2000)]);
        assert!(shown.contains("r.parquet") && shown.contains(part), "{part}: {shown}");
    }
}
