//! A contact sheet: small pictures in rows and columns with labels.

use crate::Result;
use crate::canvas::{Draw, font, titled};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Space between pictures, and height of a label above a column, in pixels.
const GAP: u32 = 4;
const LABEL: u32 = 24;

/// Pictures of the same size in rows and columns.
#[derive(Clone, Debug)]
pub struct Contact {
    /// The title.
    pub title: String,
    /// Labels of the rows and of the columns.
    pub labels: [Vec<String>; 2],
    /// Width and height of a picture, in pixels.
    pub size: [u32; 2],
    /// The pixels of each picture as sRGB, row by row; the pictures row by row.
    pub pictures: Vec<Vec<[u8; 3]>>,
}

impl Contact {
    /// Width of the labels of rows, in pixels. A letter is about 8 wide.
    fn margin(&self) -> u32 {
        let letters = self.labels[0].iter().map(|label| label.chars().count()).max().unwrap_or(0);
        8 * letters as u32 + 16
    }

    /// Width of a column, which has space for its label.
    fn width(&self) -> u32 {
        let letters = self.labels[1].iter().map(|label| label.chars().count()).max().unwrap_or(0);
        self.size[0].max(8 * letters as u32) + GAP
    }

    /// The left and the upper edge of a picture.
    fn place(&self, row: usize, column: usize) -> (i32, i32) {
        let beside = (self.width() - GAP - self.size[0]) / 2;
        let left = self.margin() + column as u32 * self.width() + beside;
        (left as i32, (LABEL + row as u32 * (self.size[1] + GAP)) as i32)
    }
}

impl Draw for Contact {
    fn size(&self) -> (u32, u32) {
        let (right, bottom) = self.place(self.labels[0].len(), self.labels[1].len());
        (right as u32 + 8, 40 + bottom as u32)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>) -> Result<()>
    where
        DB::ErrorType: 'static,
    {
        let area = titled(area, &self.title, 18.0)?;
        let [width, height] = self.size.map(|side| side as i32);
        for (i, picture) in self.pictures.iter().enumerate() {
            let (row, column) = (i / self.labels[1].len(), i % self.labels[1].len());
            let (left, top) = self.place(row, column);
            if column == 0 {
                let style = font(14.0).pos(Pos::new(HPos::Right, VPos::Center));
                area.draw_text(&self.labels[0][row], &style, (left - 8, top + height / 2))?;
            }
            if row == 0 {
                let style = font(13.0).pos(Pos::new(HPos::Center, VPos::Center));
                area.draw_text(&self.labels[1][column], &style, (left + width / 2, top - 12))?;
            }
            for (k, &[r, g, b]) in picture.iter().enumerate() {
                let (x, y) = (left + k as i32 % width, top + k as i32 / width);
                area.draw(&Rectangle::new([(x, y), (x + 1, y + 1)], RGBColor(r, g, b).filled()))?;
            }
        }
        Ok(())
    }
}
