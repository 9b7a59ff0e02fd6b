//! The container's figures: opening, one look-up, reading, walking, writing.
//!
//! `cargo bench -p vestibule-dat --bench container`

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use vestibule_dat::{DatBuilder, DatEditor, DatFile, DatKind, EditOptions, Header, WriteOptions};

/// Records of the large file: more than the largest retail file has.
const MANY: u32 = 1_000_000;
const PLAIN: WriteOptions = WriteOptions {
    version: None,
    date: None,
    iteration: None,
    compress: false,
};

/// Ids as in a cell file: landblocks of 40 cells.
fn id(i: u32) -> u32 {
    ((i / 40) << 16) + 0x100 + i % 40
}

fn build(path: &Path, n: u32) {
    let mut dat = DatBuilder::create(path, Header::new(DatKind::Cell)).unwrap();
    let mut bytes = [0x5A; 120];
    for i in 0..n {
        bytes[..4].copy_from_slice(&id(i).to_le_bytes());
        dat.push(id(i), &bytes, &PLAIN).unwrap();
    }
    dat.finish().unwrap();
}

fn scrambled(i: u32) -> u32 {
    i.wrapping_mul(2_654_435_761) % MANY
}

fn reading(c: &mut Criterion) {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("client_cell_1.dat");
    build(&path, MANY);

    c.bench_function("open a file of 1,000,000 records", |b| {
        b.iter(|| DatFile::open(black_box(&path)).unwrap());
    });

    let dat = DatFile::open(&path).unwrap();
    let mut i = 0;
    // Among 40,000 records, so that the caches are as warm as for a landblock's neighbourhood.
    c.bench_function("look up one random record of 1,000,000 (warm)", |b| {
        b.iter(|| {
            i = (i + 1) % 40_000;
            dat.find(id(black_box(scrambled(i) / 25))).unwrap().unwrap()
        });
    });
    c.bench_function("look up one random record of 1,000,000 (spread over all)", |b| {
        b.iter(|| {
            i = (i + 1) % MANY;
            dat.find(id(black_box(scrambled(i)))).unwrap().unwrap()
        });
    });
    c.bench_function("get one random record of 1,000,000, zero-copy (warm)", |b| {
        b.iter(|| {
            i = (i + 1) % 40_000;
            black_box(dat.get(id(scrambled(i) / 25)).unwrap().unwrap().len())
        });
    });

    let mut group = c.benchmark_group("walk");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(u64::from(MANY)));
    group.bench_function("list 1,000,000 entries", |b| {
        b.iter(|| dat.iter().map(|e| e.unwrap().size).sum::<u32>())
    });
    group.finish();
}

fn writing(c: &mut Criterion) {
    const N: u32 = 200_000;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("client_cell_1.dat");
    let mut group = c.benchmark_group("write");
    group
        .sample_size(10)
        .throughput(Throughput::Elements(u64::from(N)));
    group.bench_function("build a file of 200,000 small records, flushed to disk", |b| {
        b.iter(|| build(&path, N))
    });
    group.bench_function("build 200,000 small records in memory", |b| {
        b.iter(|| {
            let mut dat = DatBuilder::new("memory", Vec::new(), Header::new(DatKind::Cell)).unwrap();
            for i in 0..N {
                dat.push(id(i), &[0x5A; 120], &PLAIN).unwrap();
            }
            dat.finish().unwrap().len()
        });
    });
    group.bench_function("insert 200,000 small records in one batch, in memory", |b| {
        let empty = DatBuilder::new("memory", Vec::new(), Header::new(DatKind::Cell))
            .unwrap()
            .finish()
            .unwrap();
        b.iter_batched(
            || empty.clone(),
            |empty| {
                let mut dat = DatEditor::edit("memory", empty, EditOptions::default()).unwrap();
                for i in 0..N {
                    dat.put(id(i), &[0x5A; 120], &PLAIN).unwrap();
                }
                dat.commit().unwrap();
                dat.close().unwrap()
            },
            BatchSize::PerIteration,
        );
    });
    group.finish();
}

criterion_group!(benches, reading, writing);
criterion_main!(benches);
