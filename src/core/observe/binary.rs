//! `tables.h5`: the tables of a run in binary, one compound dataset each.
//!
//! They are made of the CSV tables once these are whole, so that a run that is resumed has nothing more to keep. Numbers are
//! those of the CSV to the last bit, since it is written with the digits that read back to the same value.

use std::path::Path;

use hdf5_pure::{
    CharacterSet, CompoundTypeBuilder, Datatype, File, FileAccessProperties, FileBuilder, FileLocking,
    MaxExtent, StringPadding, SyncPolicy,
};

use super::ObserveError;
use crate::file::draft_in;

/// Name of the file in the folder of the tables.
const NAME: &str = "tables.h5";

/// The tables, by the names of their datasets.
const TABLES: [&str; 3] = ["trajectory", "contacts", "energy"];

/// Rows of a chunk.
const CHUNK: usize = 8192;

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// A text of at most so many bytes, filled up with zeros.
    Text(usize),
    /// A count.
    Count,
    /// 0 or 1.
    Flag,
    /// A number.
    Number,
}

impl Kind {
    fn of(column: &str) -> Self {
        match column {
            "law" | "solver" | "contact" | "contact_law" => Self::Text(1),
            "step" => Self::Count,
            "lasting" => Self::Flag,
            _ => Self::Number,
        }
    }

    /// Appends a field of the CSV; a field that is none of its kind, which no table has, becomes NaN or 0.
    fn push(self, field: &[u8], row: &mut Vec<u8>) {
        let text = std::str::from_utf8(field).unwrap_or_default();
        match self {
            Self::Text(width) => {
                let end = row.len() + width;
                row.extend_from_slice(field);
                row.resize(end, 0);
            }
            Self::Count => row.extend(text.parse::<u64>().unwrap_or_default().to_le_bytes()),
            Self::Flag => row.push(u8::from(text == "true")),
            Self::Number => row.extend(text.parse::<f64>().unwrap_or(f64::NAN).to_le_bytes()),
        }
    }
}

/// The columns of a table: their names and kinds, texts as wide as the widest.
fn columns(path: &Path) -> csv::Result<Vec<(String, Kind)>> {
    let mut reader = csv::Reader::from_path(path)?;
    let header = reader.headers()?.clone();
    let mut columns: Vec<_> = header.iter().map(|name| (name.to_string(), Kind::of(name))).collect();
    let mut row = csv::ByteRecord::new();
    while reader.read_byte_record(&mut row)? {
        for ((_, kind), field) in columns.iter_mut().zip(&row) {
            if let Kind::Text(width) = kind {
                *width = field.len().max(*width);
            }
        }
    }
    Ok(columns)
}

fn datatype(columns: &[(String, Kind)]) -> Result<Datatype, hdf5_pure::FormatError> {
    let with = |builder: CompoundTypeBuilder, (name, kind): &(String, Kind)| match *kind {
        Kind::Text(width) => {
            let size = u32::try_from(width).unwrap_or(u32::MAX);
            let (padding, charset) = (StringPadding::NullPad, CharacterSet::Utf8);
            builder.field(name, Datatype::String { size, padding, charset })
        }
        Kind::Count => builder.u64_field(name),
        Kind::Flag => builder.u8_field(name),
        Kind::Number => builder.f64_field(name),
    };
    columns.iter().fold(CompoundTypeBuilder::new(), with).build()
}

/// Writes `tables.h5` into the folder of `trajectory.csv`, `contacts.csv` and `energy.csv`, of which it has the rows and
/// columns: texts as strings, `step` as an integer, `lasting` as 0 or 1, the rest in double precision.
///
/// # Errors
/// [`ObserveError`] where a table cannot be read or the file cannot be written; one that was there before then stays.
pub fn write_tables(folder: &Path) -> Result<(), ObserveError> {
    let path = folder.join(NAME);
    let failed = |error: &dyn std::fmt::Display| ObserveError::new(&path, error.to_string());
    let mut builder = FileBuilder::new();
    let mut all = Vec::new();
    for name in TABLES {
        let source = folder.join(name).with_extension("csv");
        let columns = columns(&source).map_err(|error| ObserveError::new(&source, error))?;
        let kind = datatype(&columns).map_err(|error| failed(&error))?;
        (builder.create_dataset(name).with_compound_data(kind, Vec::new(), 0))
            .with_shape(&[0])
            .with_maxshape(&[MaxExtent::Unlimited])
            .with_chunks(&[CHUNK as u64])
            .with_shuffle()
            .with_deflate(1);
        all.push((name, source, columns));
    }
    let draft = draft_in(folder).map_err(|error| failed(&error))?;
    builder.write(draft.path()).map_err(|error| failed(&error))?;
    let access =
        FileAccessProperties::new().with_locking(FileLocking::Disabled).with_sync_policy(SyncPolicy::OnClose);
    let file = File::open_rw_with_options(draft.path(), access).map_err(|error| failed(&error))?;
    for (name, source, columns) in all {
        let mut table = file.dataset(name).map_err(|error| failed(&error))?;
        let mut rows = table.buffered_appender().map_err(|error| failed(&error))?;
        let unreadable = |error: csv::Error| ObserveError::new(&source, error);
        let mut reader = csv::Reader::from_path(&source).map_err(unreadable)?;
        let (mut record, mut bytes) = (csv::ByteRecord::new(), Vec::new());
        while reader.read_byte_record(&mut record).map_err(unreadable)? {
            bytes.clear();
            columns.iter().zip(&record).for_each(|((_, kind), field)| kind.push(field, &mut bytes));
            rows.append_raw(&bytes).map_err(|error| failed(&error))?;
        }
        rows.finish().map_err(|error| failed(&error))?;
    }
    drop(file);
    draft.persist(&path).map(drop).map_err(|error| failed(&error))
}
