//! Tables of numbers, separated by commas or by blanks. Lines that begin with `#` are comments.

use super::heights::{Heights, HeightsError, MAX_POINTS, check_size};

/// Reads a table.
pub(super) fn read(text: &str) -> Result<Heights, HeightsError> {
    let (mut values, mut rows, mut columns) = (Vec::new(), 0, 0);
    let position = |part: &str| part.as_ptr() as usize - text.as_ptr() as usize;
    for line in text.lines().filter(|line| !line.trim().is_empty() && !line.trim_start().starts_with('#')) {
        let before = values.len();
        let mut cell = |cell: &str| {
            let cell = cell.trim();
            // Of a row that is too long only its length is of interest.
            if values.len() - before > MAX_POINTS {
                return Ok(());
            }
            match cell.parse::<f64>().ok().filter(|value| value.is_finite()) {
                Some(value) => values.push(value),
                None => {
                    let start = position(cell);
                    let message = format!("expected a finite number, found {cell:?}");
                    return Err(HeightsError::at(start..start + cell.len(), message));
                }
            }
            Ok(())
        };
        match line.contains(',') {
            true => line.split(',').try_for_each(&mut cell)?,
            false => line.split_whitespace().try_for_each(&mut cell)?,
        }
        let count = values.len() - before;
        rows += 1;
        if rows == 1 {
            columns = count;
        }
        let span = position(line)..position(line) + line.len();
        if columns > MAX_POINTS || rows > MAX_POINTS {
            let what = if rows > MAX_POINTS { "rows" } else { "columns" };
            let message = format!("the grid has more than {MAX_POINTS} {what}, which is the most that is allowed");
            return Err(HeightsError::at(span, message));
        }
        if count != columns {
            let message = format!("this row has {count} heights, the first one has {columns}");
            return Err(HeightsError::at(span, message));
        }
    }
    check_size(rows, columns)?;
    Ok(Heights { rows, columns, values })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> (String, String) {
        let error = read(text).unwrap_err();
        (error.span.map_or(String::new(), |span| text[span].to_owned()), error.message)
    }

    #[test]
    fn tables_may_have_comments_blanks_and_either_separator() {
        let expected = Heights { rows: 2, columns: 3, values: vec![0.0, -1.5, 2e-3, 4.0, 5.0, 6.0] };
        for text in ["0,-1.5,2e-3\n4,5,6", "# heights\n\n 0 , -1.5,\t2e-3 \r\n4,5,6\r\n", "0 -1.5\t2e-3\n  4 5  6\n"] {
            assert_eq!(read(text).unwrap(), expected, "{text:?}");
        }
    }

    #[test]
    fn broken_tables_are_refused_at_their_cell_or_row() {
        let pair = |at: &str, message: &str| (at.to_owned(), message.to_owned());
        assert_eq!(error("0,1\n2,x\n"), pair("x", "expected a finite number, found \"x\""));
        assert_eq!(error("0,1\n2,\n"), pair("", "expected a finite number, found \"\""));
        assert_eq!(error("0,1\n2,inf\n"), pair("inf", "expected a finite number, found \"inf\""));
        assert_eq!(error("0 1\n2 nan\n"), pair("nan", "expected a finite number, found \"nan\""));
        assert_eq!(error("0,1\n2,3,4\n"), pair("2,3,4", "this row has 3 heights, the first one has 2"));
        let size = "the grid has 1 x 2 heights (rows x columns); from 2 to 4096 rows and columns are allowed";
        assert_eq!(error("0,1\n"), pair("", size));
        assert!(error("").1.starts_with("the grid has 0 x 0 heights"));
        assert_eq!(error(&format!("{}\n", "1 ".repeat(5000))).1, MANY.replace("WHAT", "columns"));
        assert_eq!(error(&"1 2\n".repeat(4097)).1, MANY.replace("WHAT", "rows"));
    }

    const MANY: &str = "the grid has more than 4096 WHAT, which is the most that is allowed";
}
