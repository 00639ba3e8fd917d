//! Sheets are read back as they were written; a sheet of other settings is not taken for this one.

use super::*;

fn sheet() -> Sheet {
    let mut sheet = Sheet { alone_us: 1234.5, ..Sheet::default() };
    for scheme in 0..SCHEMES.len() {
        for (number, short) in
            [None, Some((Beyond::Swap, 1)), Some((Beyond::Evict, 0))].into_iter().enumerate()
        {
            let place = Place { byte: 1, short, depth: 4, scheme };
            let value = 10.0 + number as f64;
            let spread = |mean| Spread { mean, deviation: 0.5, count: 16 };
            let point = Point {
                time_us: spread(value),
                moved: spread(value / 8.0),
                swapped: 0.25,
                out: 0.5,
                peak: 0.75,
            };
            sheet.points.insert(place, point);
        }
    }
    sheet
}

#[test]
fn a_sheet_is_read_back_as_it_was_written() {
    let sheet = sheet();
    let text = sheet.text("these settings");
    assert_eq!(Sheet::parse(&text, "these settings"), Some(sheet));
    assert_eq!(Sheet::parse(&text, "other settings"), None);
    for end in 0..text.len() {
        // Files are replaced as a whole, so one that ends within a line was not written by this.
        if let Some(part) = text.get(..end).filter(|part| !part.ends_with('\n')) {
            assert_eq!(Sheet::parse(part, "these settings"), None, "{end}");
        }
    }
    assert_eq!(Sheet::parse(&text.replace("evict", "forget"), "these settings"), None);
}

#[test]
fn where_memory_suffices_the_point_is_the_same_as_with_any_amount_of_it() {
    let sheet = sheet();
    let time = |short| sheet.curves(1, short).line(Scheme::BestMatch)[0].1.time_us.mean;
    assert_eq!(time(None), 10.0);
    assert_eq!(time(Some((Beyond::Swap, 1))), 11.0);
    assert_eq!(time(Some((Beyond::Evict, 0))), 12.0);
    assert_eq!(time(Some((Beyond::Swap, 7))), 10.0);
    assert!(sheet.curves(0, None).line(Scheme::BestMatch).is_empty());
}

#[test]
fn a_spread_is_that_of_its_values() {
    let spread = Spread::over(&[1.0, 2.0, 3.0]);
    assert!((spread.mean - 2.0).abs() < 1e-12 && (spread.deviation - 1.0).abs() < 1e-12);
    assert!((spread.error() - 1.0 / 3.0_f64.sqrt()).abs() < 1e-12);
    assert_eq!(Spread::over(&[4.0]), Spread { mean: 4.0, deviation: 0.0, count: 1 });
    let speed_up = spread.under(8.0);
    assert!((speed_up.mean - 4.0).abs() < 1e-12 && (speed_up.deviation - 2.0).abs() < 1e-12);
}
