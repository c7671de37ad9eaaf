//! Which axis of the array is what, and where the samples are.

use glam::{DAffine3, DVec3};
use pellucid_field::Warning;

use super::fields::NrrdHeader;
use crate::IoError;
use crate::header::Field;
use crate::world::{Frame, affine_from_steps, millimetres, to_world};

/// The shape of the array in this engine's terms.
pub(super) struct Shape {
    pub dims: [usize; 3],
    pub components: usize,
    /// Whether the components are slower than the axes of space.
    pub planar: bool,
    pub frames: u64,
    pub world_from_index: DAffine3,
    pub length_unit: Option<String>,
    /// Whether the space is a patient's.
    pub is_anatomical: bool,
}

/// What an axis of the array runs along.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Role {
    Space,
    Components,
    Time,
    /// A single sample of something that is not space.
    Nothing,
}

impl Shape {
    pub fn parse(header: &NrrdHeader, warnings: &mut Vec<Warning>) -> Result<Self, IoError> {
        let dimension: usize = header.require("dimension", "the number of axes")?.number("a number of axes")?;
        if !(1..=16).contains(&dimension) {
            return Err(IoError::malformed(&header.source.path, "dimension", dimension, "1 to 16"));
        }
        let why = format!("'dimension: {dimension}'");
        let sizes_field = header.require("sizes", "the number of samples along each axis")?;
        let sizes: Vec<usize> = sizes_field.numbers(dimension, &why)?;
        if sizes.contains(&0) {
            return Err(sizes_field.error("at least 1 sample along every axis"));
        }
        let space = Space::parse(header, dimension)?;
        let roles = roles(header, &sizes, &space, &why, warnings)?;
        let axes: Vec<usize> = (0..dimension).filter(|&axis| roles[axis] == Role::Space).collect();
        let (order, mut components, mut frames) = (order(&roles), 1, 1);
        // Memory has components first, or each component as a whole grid, and then time.
        let planar = order.trim_end_matches('t').ends_with('c');
        let supported = order.trim_start_matches('c').trim_end_matches('t').trim_end_matches('c');
        let once = order.matches('c').count() <= 1 && order.matches('t').count() <= 1;
        if !once || supported.contains(['c', 't']) || !(1..=3).contains(&axes.len()) {
            let advice = "one to three axes of space, before or after them one of components, and last one of time";
            let found = header.get("kinds").map_or(sizes_field.text, |field| field.text);
            return Err(IoError::unsupported(&header.source.path, "the order of axes", found, advice));
        }
        for axis in 0..dimension {
            match roles[axis] {
                Role::Components => components = sizes[axis],
                Role::Time => frames = sizes[axis] as u64,
                Role::Space | Role::Nothing => {}
            }
        }
        let mut dims = [1; 3];
        for (n, &axis) in dims.iter_mut().zip(&axes) {
            *n = sizes[axis];
        }
        let file_from_index = space.affine(header, &axes, &sizes, &why)?;
        let (unit, scale) = length_unit(header, &axes, &why, space.frame, warnings)?;
        let world_from_index = to_world(file_from_index, space.frame, scale);
        if space.frame == Frame::LeftHanded {
            let line = "the space is left-handed: z is mirrored to keep the shape of things in a right-handed world";
            warnings.push(Warning::File(line.to_owned()));
        }
        let is_anatomical = space.frame.is_anatomical();
        Ok(Self { dims, components, planar, frames, world_from_index, length_unit: unit, is_anatomical })
    }
}

/// The roles of the axes as a word: `csss`, `ssst`.
fn order(roles: &[Role]) -> String {
    let letter = |role: &Role| match role {
        Role::Space => Some('s'),
        Role::Components => Some('c'),
        Role::Time => Some('t'),
        Role::Nothing => None,
    };
    roles.iter().filter_map(letter).collect()
}

fn roles(
    header: &NrrdHeader,
    sizes: &[usize],
    space: &Space,
    why: &str,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Role>, IoError> {
    let dimension = sizes.len();
    let kinds = header.get("kinds").map(|field| field.words(dimension, why)).transpose()?;
    let kinds: Vec<String> = match kinds {
        Some(kinds) => kinds.into_iter().map(str::to_lowercase).collect(),
        None => vec!["none".to_owned(); dimension],
    };
    let mut roles: Vec<Role> = (0..dimension)
        .map(|axis| {
            let of_space = match &space.directions {
                Some(directions) => directions[axis].is_some(),
                None => matches!(kinds[axis].as_str(), "domain" | "space" | "???" | "none"),
            };
            match kinds[axis].as_str() {
                _ if of_space => Role::Space,
                _ if sizes[axis] == 1 => Role::Nothing,
                "time" => Role::Time,
                // Lists of images and axes without a name: one after the other in time.
                "list" | "domain" | "space" | "???" | "none" if axis + 1 == dimension => Role::Time,
                _ => Role::Components,
            }
        })
        .collect();
    if space.directions.is_none() && dimension == 4 && roles.iter().all(|&role| role == Role::Space) {
        let (axis, role, what) = if sizes[0] <= 4 && sizes[3] > 4 {
            (0, Role::Components, "first axis holds components")
        } else {
            (3, Role::Time, "last axis is time")
        };
        roles[axis] = if sizes[axis] == 1 { Role::Nothing } else { role };
        warnings.push(Warning::File(format!("four axes without kinds: guessed that the {what}")));
    }
    Ok(roles)
}

/// The space that the array lies in.
struct Space {
    frame: Frame,
    /// Components of its vectors, 0 if none is stated.
    dimension: usize,
    /// One step per axis of the array; `None` for an axis that is not of space.
    directions: Option<Vec<Option<DVec3>>>,
}

impl Space {
    fn parse(header: &NrrdHeader, dimension: usize) -> Result<Self, IoError> {
        let (mut frame, mut space_dimension) = (Frame::Unstated, 0);
        if let Some(field) = header.get("space") {
            let name = field.text.to_lowercase().replace(['-', ' ', '_'], "");
            let (name, in_time) = match name.strip_suffix("time") {
                Some(name) => (name, 1),
                None if matches!(&*name, "rast" | "last" | "lpst") => (&name[..3], 1),
                None => (&*name, 0),
            };
            space_dimension = 3 + in_time;
            frame = match name {
                "rightanteriorsuperior" | "ras" => Frame::Ras,
                "leftanteriorsuperior" | "las" => Frame::Las,
                "leftposteriorsuperior" | "lps" => Frame::Lps,
                "3dlefthanded" => Frame::LeftHanded,
                "scannerxyz" | "3drighthanded" => Frame::Unstated,
                _ => return Err(field.error(
                    "right-, left-anterior-superior, left-posterior-superior, scanner-xyz, 3D-right- or 3D-left-handed",
                )),
            };
        }
        if let Some(field) = header.get("space dimension") {
            space_dimension = field.number("a number")?;
            if !(1..=4).contains(&space_dimension) {
                return Err(field.error("1 to 4"));
            }
        }
        let directions = header.get("space directions").map(|field| {
            let mut vectors = vectors(field, space_dimension)?;
            if space_dimension == 4 {
                // A step through time alone.
                vectors.iter_mut().for_each(|step| *step = step.filter(|&step| step != DVec3::ZERO));
            }
            if vectors.len() != dimension {
                return Err(field.error(format!("{dimension} vectors or 'none' to match 'dimension: {dimension}'")));
            }
            Ok(vectors)
        });
        Ok(Self { frame, dimension: space_dimension, directions: directions.transpose()? })
    }

    /// Where the samples of the axes of space are, in the file's own frame.
    fn affine(&self, header: &NrrdHeader, axes: &[usize], sizes: &[usize], why: &str) -> Result<DAffine3, IoError> {
        let mut origin = DVec3::ZERO;
        let steps: Vec<DVec3> = match &self.directions {
            Some(directions) => axes.iter().filter_map(|&axis| directions[axis]).collect(),
            None => {
                let mut steps = Vec::new();
                for (position, &axis) in axes.iter().enumerate() {
                    let (step, first) = placed_by_axis(header, axis, sizes, why)?;
                    let mut along = DVec3::ZERO;
                    along[position] = step;
                    steps.push(along);
                    origin[position] = first;
                }
                steps
            }
        };
        if let Some(field) = header.get("space origin") {
            let mut points = vectors(field, self.dimension)?.into_iter();
            match (points.next(), points.next()) {
                (Some(Some(point)), None) => origin = point,
                _ => return Err(field.error("one vector")),
            }
        }
        Ok(affine_from_steps(&steps, origin))
    }
}

/// Spacing and first position along an axis that has no direction.
fn placed_by_axis(header: &NrrdHeader, axis: usize, sizes: &[usize], why: &str) -> Result<(f64, f64), IoError> {
    let number = |name| -> Result<Option<f64>, IoError> {
        let Some(field) = header.get(name) else { return Ok(None) };
        // NaN is how the format says "not known" for one axis.
        Ok(Some(field.numbers::<f64>(sizes.len(), why)?[axis]).filter(|number| !number.is_nan()))
    };
    let (low, high) = (number("axis mins")?, number("axis maxs")?);
    let centers = header.get("centers").map(|field| field.words(sizes.len(), why)).transpose()?;
    // The minimum of a cell-centred axis is the edge of its first cell, half a step before its
    // sample; cells are the format's default.
    let at_nodes = centers.is_some_and(|centers| centers[axis].eq_ignore_ascii_case("node"));
    let intervals = if at_nodes { sizes[axis] - 1 } else { sizes[axis] };
    let span = low.zip(high).map(|(low, high)| high - low).filter(|_| intervals > 0);
    let step = number("spacings")?.or(span.map(|span| span / intervals as f64)).unwrap_or(1.0);
    let first = low.map_or(0.0, |low| if at_nodes { low } else { low + step / 2.0 });
    Ok((step, first))
}

/// The unit of world lengths, and the factor that brings the file's to it.
fn length_unit(
    header: &NrrdHeader,
    axes: &[usize],
    why: &str,
    frame: Frame,
    warnings: &mut Vec<Warning>,
) -> Result<(Option<String>, f64), IoError> {
    let mut units: Vec<&str> = Vec::new();
    let (space_units, axis_units) = (header.get("space units"), header.get("units"));
    if let Some(field) = space_units {
        units = field.quoted().into_iter().take(3).collect();
    } else if let Some(field) = axis_units {
        let all = field.quoted();
        if all.len() != header.require("sizes", "sizes")?.text.split_whitespace().count() {
            return Err(field.error(format!("one string in double quotes per axis to match {why}")));
        }
        units = axes.iter().map(|&axis| all[axis]).collect();
    }
    units.retain(|unit| !unit.is_empty() && *unit != "???");
    let unit = units.first().copied();
    if units.iter().any(|&other| Some(other) != unit) {
        warnings.push(Warning::File(format!("lengths have different units ({}): none is applied", units.join(", "))));
        return Ok((None, 1.0));
    }
    if !frame.is_anatomical() {
        return Ok((unit.map(str::to_owned), 1.0));
    }
    let Some(unit) = unit else { return Ok((Some("mm".to_owned()), 1.0)) };
    match millimetres(unit) {
        Some(scale) => Ok((Some("mm".to_owned()), scale)),
        None => {
            warnings.push(Warning::File(format!("the unit of length '{unit}' is not known: taken as it is")));
            Ok((Some(unit.to_owned()), 1.0))
        }
    }
}

/// Vectors such as `(1,0,0) none (0, 0, 1)`. Parts beyond the third, of time, are left out.
fn vectors(field: Field, dimension: usize) -> Result<Vec<Option<DVec3>>, IoError> {
    if dimension == 0 {
        return Err(field.error("a field 'space' or 'space dimension' before it"));
    }
    let malformed = || field.error(format!("vectors of {dimension} numbers, such as (1,0,0), or 'none'"));
    let mut vectors = Vec::new();
    let mut rest = field.text.trim_start();
    while !rest.is_empty() {
        if let Some(inside) = rest.strip_prefix('(') {
            let (inside, after) = inside.split_once(')').ok_or_else(malformed)?;
            let numbers: Vec<f64> =
                inside.split(',').map(|word| word.trim().parse()).collect::<Result<_, _>>().map_err(|_| malformed())?;
            if numbers.len() != dimension {
                return Err(malformed());
            }
            let part = |axis: usize| numbers.get(axis).copied().unwrap_or(0.0);
            vectors.push(Some(DVec3::new(part(0), part(1), part(2))));
            rest = after.trim_start();
        } else {
            let rest_of_word = rest.strip_prefix("none").ok_or_else(malformed)?;
            vectors.push(None);
            rest = rest_of_word.trim_start();
        }
    }
    Ok(vectors)
}
