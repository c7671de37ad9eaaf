//! The picture that a timed one should be, and how far it is from that: no speed without its error.

use std::fmt;
use std::path::PathBuf;

use pellucid::Backend;
use pellucid::io::read_png;
use pellucid::scene::{Frame, Stage};
use serde_json::{Value, json};

use super::meter::{Meter, Plan};
use super::subject::Subject;
use crate::difference::Difference;
use crate::failure::Failure;

/// Where the reference comes from.
#[derive(Clone, Debug)]
pub enum Reference {
    /// The processor, with steps so many times finer and every ray followed to its end.
    Drawn(u8),
    /// A file.
    Given(PathBuf),
}

impl fmt::Display for Reference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drawn(1) => f.write_str("the processor's at the same step"),
            Self::Drawn(finer) => write!(f, "the processor's at a step {finer} times finer"),
            Self::Given(path) => path.display().fmt(f),
        }
    }
}

/// The error of the first picture timed.
pub struct Error {
    /// What it is compared with, in words.
    pub reference: String,
    /// How far it is from that.
    pub difference: Difference,
}

impl Error {
    /// One line.
    pub fn text(&self) -> String {
        let Difference { psnr, largest, mean } = self.difference;
        format!(
            "picture error: PSNR {psnr:.1} dB, largest {largest}, mean {mean:.3} of 255, against {}\n",
            self.reference
        )
    }

    /// The same for programs.
    pub fn json(&self) -> Value {
        let Difference { largest, mean, .. } = self.difference;
        json!({
            "reference": self.reference,
            "psnr_db": self.difference.psnr_json(),
            "largest_difference": largest,
            "mean_difference": mean,
        })
    }
}

impl Reference {
    /// Compares the first picture timed with the reference.
    pub fn compare(&self, subject: &Subject, first: &Frame, plan: Plan) -> Result<Error, Failure> {
        let expected = match self {
            Self::Drawn(finer) => drawn(subject, *finer, plan)?.to_rgba8(&subject.stage.image),
            Self::Given(path) => {
                let picture = read_png(path)?;
                let found = [picture.width as usize, picture.height as usize];
                if found != [first.width, first.height] {
                    return Err(Failure::input(format_args!(
                        "{}: the picture is {}x{}, those timed are {}x{}",
                        path.display(),
                        found[0],
                        found[1],
                        first.width,
                        first.height
                    )));
                }
                picture.pixels.as_flattened().iter().map(|channel| (channel * 255.0).round() as u8).collect()
            }
        };
        let difference = Difference::between(&first.to_rgba8(&subject.stage.image), &expected);
        Ok(Error { reference: self.to_string(), difference })
    }
}

/// The picture of the processor.
fn drawn(subject: &Subject, finer: u8, plan: Plan) -> Result<Frame, Failure> {
    let mut stage: Stage = subject.stage.clone();
    stage.step /= f64::from(finer);
    stage.quality.early_termination = 1.0;
    stage.quality.adaptive_tolerance = 0.0;
    let mut frame = Frame::default();
    let engine = plan.engine.on(Backend::Cpu);
    Meter::new(Plan { engine, ..plan })?.frame(&mut stage, &mut frame, |_| Ok(()))?;
    Ok(frame)
}
