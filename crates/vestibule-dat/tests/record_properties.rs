//! What holds for every record: it survives encoding and parsing, and no damage makes the parser do worse than fail.

mod generate;

use generate::Entropy;
use proptest::prelude::*;
use vestibule_dat::RecordKind;
use vestibule_dat::record::{Record, RoundTrip, round_trip};

fn entropy() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(any::<u8>(), 0..3000)
}

/// Parses anything; what parses must be written back as it was, padding aside.
fn survives(kind: RecordKind, bytes: &[u8]) -> Result<(), TestCaseError> {
    match round_trip(kind, 0x1234_5678, bytes) {
        Ok(outcome) => prop_assert!(
            !matches!(outcome, RoundTrip::Different { .. }),
            "{kind}: {outcome:?}"
        ),
        Err(error) => {
            prop_assert_eq!(error.id, 0x1234_5678);
            prop_assert!(error.offset <= bytes.len(), "{error}");
            prop_assert!(!error.field.is_empty());
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn d5_what_is_written_reads_back_the_same(entropy in entropy()) {
        let record = Entropy(&entropy).record();
        let bytes = record.encode().unwrap();
        let read = Record::parse(record.kind(), 0, &bytes).unwrap();
        // Debug text, because NaN is not equal to itself.
        prop_assert_eq!(format!("{read:?}"), format!("{record:?}"));
        prop_assert_eq!(read.encode().unwrap(), bytes.as_slice());
        prop_assert_eq!(round_trip(record.kind(), 0, &bytes), Ok(RoundTrip::Identical));
    }

    #[test]
    fn d1_random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        for &kind in RecordKind::ALL {
            survives(kind, &bytes)?;
        }
    }

    #[test]
    fn d1_small_words_never_panic(words in prop::collection::vec(0u32..4, 0..150)) {
        let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
        for &kind in RecordKind::ALL {
            survives(kind, &bytes)?;
        }
    }

    #[test]
    fn d1_flipped_bits_never_panic(
        entropy in entropy(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0u32..8), 1..4),
    ) {
        let record = Entropy(&entropy).record();
        let mut bytes = record.encode().unwrap();
        for (place, bit) in flips {
            let place = place.index(bytes.len());
            bytes[place] ^= 1u8 << bit;
        }
        survives(record.kind(), &bytes)?;
    }

    #[test]
    fn d2_truncation_is_an_error_that_names_the_place(entropy in entropy(), cut in any::<prop::sample::Index>()) {
        let record = Entropy(&entropy).record();
        let bytes = record.encode().unwrap();
        let cut = cut.index(bytes.len());
        let error = Record::parse(record.kind(), 0xABCD, &bytes[..cut]).unwrap_err();
        prop_assert_eq!(error.id, 0xABCD);
        prop_assert!(error.offset <= cut);
    }

    #[test]
    fn f6_bytes_left_over_are_an_error(entropy in entropy()) {
        let record = Entropy(&entropy).record();
        let mut bytes = record.encode().unwrap();
        bytes.push(0);
        prop_assert!(Record::parse(record.kind(), 0, &bytes).is_err());
    }
}
