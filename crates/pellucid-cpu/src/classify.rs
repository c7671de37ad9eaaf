//! Classification: where samples get colour and opacity.

use glam::DVec3;
use pellucid_field::{Filter, Volume};
use pellucid_optics::{Nodes, PreIntegration, StepTable, Table};

use crate::element::Element;
use crate::field::{Any, Corners, Field, Moved, lane_position};
use crate::lanes::*;
use crate::samples::Sample;

/// A table of linear RGB and opacity in the shape lanes look it up (4.1-4).
pub struct Lookup<'a> {
    entries: &'a [[f32; 4]],
    nodes: Nodes,
    /// Entries of one table; those of longer strides follow it, if there are any.
    count: usize,
    /// Between these positions, exclusive, lie all entries with any opacity.
    hull: [f32; 2],
}

impl<'a> Lookup<'a> {
    /// Associated colours for one step.
    pub fn of_steps(table: &'a StepTable) -> Self {
        Self::new(table.entries(), table.nodes())
    }

    /// Associated colours of one step and, one table after the other, of longer strides.
    pub fn of_strides(entries: &'a [[f32; 4]], nodes: &Nodes) -> Self {
        Self::new(entries, nodes)
    }

    /// Colours and opacities per unit distance.
    pub fn of_table(table: &'a Table) -> Self {
        Self::new(table.entries(), table.nodes())
    }

    /// Rows of any four numbers.
    pub fn of_rows(entries: &'a [[f32; 4]], nodes: &Nodes) -> Self {
        Self::new(entries, nodes)
    }

    fn new(entries: &'a [[f32; 4]], nodes: &Nodes) -> Self {
        let count = nodes.count();
        assert!(count >= 2 && entries.len() >= count && entries.len().is_multiple_of(count));
        let first_table = &entries[..count];
        let visible = |entry: &[f32; 4]| entry[3] > 0.0;
        let hull = match (first_table.iter().position(visible), first_table.iter().rposition(visible)) {
            // Beyond an end of the table its last entry goes on.
            (Some(first), Some(last)) => [
                if first == 0 { f32::NEG_INFINITY } else { first as f32 - 1.0 },
                if last + 1 == count { f32::INFINITY } else { last as f32 + 1.0 },
            ],
            _ => [f32::INFINITY, f32::NEG_INFINITY],
        };
        Self { entries, nodes: nodes.clone(), count, hull }
    }

    /// The position of values among the nodes.
    #[inline(always)]
    pub fn position<S: Lanes>(&self, s: S, values: F32<S>) -> F32<S> {
        position(s, &self.nodes, values)
    }

    /// Lanes whose position may have opacity; never those without a value.
    #[inline(always)]
    pub fn may_be_visible<S: Lanes>(&self, s: S, position: F32<S>) -> Mask<S> {
        position.simd_gt(splat(s, self.hull[0])) & position.simd_lt(splat(s, self.hull[1]))
    }

    /// The entries at positions, of the table of a level; any entry in lanes that are not a number.
    #[inline(always)]
    pub fn at<S: Lanes>(&self, s: S, position: F32<S>, level: Option<I32<S>>) -> [F32<S>; 4] {
        let last = self.count - 1;
        let (node, t) = cell(s, limited(s, position, last), last);
        let node = match level {
            Some(level) => {
                let most = (self.entries.len() / self.count) as i32 - 1;
                node + level.max(whole(s, 0)).min(whole(s, most)) * self.count as i32
            }
            None => node,
        };
        // SAFETY: `cell` gives a node from 0 to the last but one, of a table that is there.
        let (from, to) = unsafe {
            let base = self.entries.as_ptr().cast::<f32>();
            (s.gather_rows::<2>(base, node), s.gather_rows::<2>(base.add(4), node))
        };
        rgba!(C => lerp::<S>(t, from[C], to[C]))
    }

    /// The entries at values; zero where there is none.
    #[inline(always)]
    pub fn lookup<S: Lanes>(&self, s: S, values: F32<S>) -> [F32<S>; 4] {
        let present = values.is_finite();
        let found = self.at(s, self.position(s, values), None);
        rgba!(C => present.select(found[C], splat(s, 0.0)))
    }
}

/// The position of values among nodes: the vectors' form of [`Nodes::position`].
#[inline(always)]
fn position<S: Lanes>(s: S, nodes: &Nodes, values: F32<S>) -> F32<S> {
    match nodes.knots() {
        [] => (values - splat(s, nodes.origin())) * nodes.scale(),
        knots => between_knots(s, knots, values),
    }
}

/// The position of values among nodes that are not even. A function of its own, so that even ones find the registers
/// that they had without it.
#[inline(never)]
fn between_knots<S: Lanes>(s: S, knots: &[[f32; 4]], values: F32<S>) -> F32<S> {
    /// So many are passed one after the other in the time that gathers take to halve more of them.
    const FEW: usize = 16;
    s.vectorize(
        #[inline(always)]
        || {
            if knots.len() <= FEW {
                let mut last = [splat(s, 0.0); 3];
                for (k, knot) in knots.iter().enumerate() {
                    let passed = if k == 0 { all(s, true) } else { values.simd_ge(splat(s, knot[0])) };
                    last = xyz!(I => passed.select(splat(s, knot[I]), last[I]));
                }
                let [value, node, slope] = last;
                return (values - value).mul_add(slope, node);
            }
            let base = knots.as_ptr().cast::<f32>();
            let (mut at, mut step) = (whole(s, 0), knots.len() / 2);
            while step > 0 {
                let next = at + step as i32;
                // SAFETY: the steps halve from half of their number, a power of two: all their sums are below it.
                let limit: F32<S> = unsafe { s.gather::<4>(base.cast(), next << 2) }.bitcast();
                at = values.simd_ge(limit).select(next, at);
                step /= 2;
            }
            // SAFETY: as above.
            let [value, node, slope, _] = unsafe { s.gather_rows::<2>(base, at) };
            (values - value).mul_add(slope, node)
        },
    )
}

/// Positions limited to 0 to `last`; 0 where there is no number.
#[inline(always)]
fn limited<S: Lanes>(s: S, position: F32<S>, last: usize) -> F32<S> {
    within(s, position, last as f32)
}

/// The node below a limited position, at most the last but one, and the fraction towards the next.
#[inline(always)]
fn cell<S: Lanes>(s: S, limited: F32<S>, last: usize) -> (I32<S>, F32<S>) {
    let node = limited.to_int::<I32<S>>().min(whole(s, last as i32 - 1));
    (node, limited - node.to_float::<F32<S>>())
}

/// Classifies single samples.
pub trait Classify<S: Lanes>: Sync {
    /// Samples with these values, or `None` if none has any opacity.
    fn classify(&self, s: S, value: F32<S>, sample: &Sample<S>) -> Option<Element<S>>;
}

/// The transfer function applied to the interpolated value (4.3-1).
pub struct Post<'a>(pub Lookup<'a>);

impl<S: Lanes> Classify<S> for Post<'_> {
    #[inline(always)]
    fn classify(&self, s: S, value: F32<S>, sample: &Sample<S>) -> Option<Element<S>> {
        self.of_level(s, value, sample.lanes, sample.level)
    }
}

impl Post<'_> {
    /// Samples with these values, of the table of a level.
    #[inline(always)]
    pub fn of_level<S: Lanes>(&self, s: S, value: F32<S>, lanes: Mask<S>, level: Option<I32<S>>) -> Option<Element<S>> {
        let position = self.0.position(s, value);
        let candidates = lanes & self.0.may_be_visible(s, position);
        if !candidates.any_true() {
            return None;
        }
        let rgba = self.0.at(s, position, level);
        let visible = candidates & rgba[3].simd_gt(splat(s, 0.0));
        Some(Element { rgba, visible })
    }
}

/// The transfer function applied to the voxels, interpolating their associated colours (4.2-1,
/// 3.2-8). An absent voxel has neither colour nor opacity.
pub struct Pre<'a, S> {
    /// The voxels around samples, as far as lanes can ask for them: under a linear filter.
    pub field: Any<'a, S>,
    /// Associated entries for one step.
    pub lookup: Lookup<'a>,
    /// All other filters, and data that lanes cannot read.
    pub each: PreEach<'a>,
}

impl<S: Lanes> Classify<S> for Pre<'_, S> {
    #[inline(always)]
    fn classify(&self, s: S, _: F32<S>, &Sample { index, lanes, .. }: &Sample<S>) -> Option<Element<S>> {
        let rgba = match if self.each.is_linear() { self.field.corners(s, index, lanes) } else { None } {
            Some(corners) => self.blend(s, &corners, lanes)?,
            None => self.each.colors(s, &index, lanes),
        };
        let visible = lanes & rgba[3].simd_gt(splat(s, 0.0));
        if !visible.any_true() {
            return None;
        }
        Some(Element { rgba, visible })
    }
}

impl<S: Lanes> Pre<'_, S> {
    /// The colours of corners, interpolated; `None` if none has any opacity.
    #[inline(always)]
    fn blend(&self, s: S, Corners { values, u }: &Corners<S>, lanes: Mask<S>) -> Option<[F32<S>; 4]> {
        let nothing = [splat(s, 0.0); 4];
        let (mut colors, mut any) = ([nothing; 8], all(s, false));
        for (color, value) in colors.iter_mut().zip(values) {
            let position = self.lookup.position(s, *value);
            let visible = lanes & self.lookup.may_be_visible(s, position);
            if visible.any_true() {
                let found = self.lookup.at(s, position, None);
                *color = rgba!(C => visible.select(found[C], nothing[C]));
                any |= visible;
            }
        }
        if !any.any_true() {
            return None;
        }
        // Along x, then y, then z.
        Some(rgba!(C => {
            let [a, b, c, d] = rgba!(R => lerp::<S>(u[0], colors[2 * R][C], colors[2 * R + 1][C]));
            lerp::<S>(u[2], lerp::<S>(u[1], a, b), lerp::<S>(u[1], c, d))
        }))
    }
}

/// The same, one lane after the other.
pub struct PreEach<'a> {
    /// Associated entries for one step.
    pub table: &'a StepTable,
    /// The voxels.
    pub volume: &'a Volume,
    /// Which component is classified.
    pub component: usize,
    /// How colours are interpolated.
    pub filter: Filter,
    /// What moves them, with the field that says how far.
    pub moved: Moved<'a>,
}

impl PreEach<'_> {
    #[inline(always)]
    fn is_linear(&self) -> bool {
        self.filter == Filter::Linear
    }

    #[inline(never)]
    fn colors<S: Lanes>(&self, s: S, index: &Vec3<S>, lanes: Mask<S>) -> [F32<S>; 4] {
        let mut rgba = [splat(s, 0.0); 4];
        let bits = lanes.to_bitmask();
        for lane in (0..width::<S>()).filter(|lane| bits >> lane & 1 == 1) {
            for (channel, value) in rgba.iter_mut().zip(self.color(lane_position::<S>(index, lane))) {
                channel[lane] = value;
            }
        }
        rgba
    }
}

impl PreEach<'_> {
    fn color(&self, index: DVec3) -> [f32; 4] {
        let index = self.moved.source(index);
        let dims = self.volume.grid().dims();
        let reach = self.filter.half_width() as isize;
        let inside = |axis: usize| index[axis].clamp(0.0, (dims[axis] - 1) as f64);
        let cell: [isize; 3] = std::array::from_fn(|axis| inside(axis).floor() as isize);
        let weights: [_; 3] = std::array::from_fn(|axis| self.filter.weights(inside(axis).fract()));
        let voxel = |axis: usize, tap: usize| {
            (cell[axis] + 1 - reach + tap as isize).clamp(0, dims[axis] as isize - 1) as usize
        };
        let mut sum = [0.0f64; 4];
        for (k, wz) in weights[2].iter().enumerate() {
            for (j, wy) in weights[1].iter().enumerate() {
                for (i, wx) in weights[0].iter().enumerate() {
                    let weight = wx * wy * wz;
                    if weight == 0.0 {
                        continue;
                    }
                    let value = self.volume.value([voxel(0, i), voxel(1, j), voxel(2, k)], self.component);
                    let rgba = self.table.lookup(value as f32);
                    for (sum, channel) in sum.iter_mut().zip(rgba) {
                        *sum += weight * f64::from(channel);
                    }
                }
            }
        }
        // Filters with negative weights overshoot.
        sum.map(|channel| channel.clamp(0.0, 1.0) as f32)
    }
}

/// Colour and opacity by the values at both ends of a segment (4.6-7).
pub struct Segments<'a>(pub &'a PreIntegration);

impl Segments<'_> {
    /// Associated linear RGB and opacity of segments from `front` to `back`, both present, that are `length` steps
    /// long: the vectors' form of [`PreIntegration::over_length`].
    #[inline(always)]
    pub fn lookup<S: Lanes>(&self, s: S, [front, back]: [F32<S>; 2], length: F32<S>, lanes: Mask<S>) -> [F32<S>; 4] {
        let nodes = self.0.nodes();
        let last = nodes.count() - 1;
        let x = limited(s, position(s, nodes, front), last);
        let y = limited(s, position(s, nodes, back), last);
        let mut rgba = self.bilinear(s, x, y);
        if (lanes & length.simd_ne(splat(s, 1.0))).any_true() {
            rgba = self.over(s, rgba, [x, y], length);
        }
        // Segments that leave the domain are composed of parts, which is rare.
        let [low, high] = nodes.ends();
        let beyond = front.simd_lt(splat(s, low))
            | front.simd_gt(splat(s, high))
            | back.simd_lt(splat(s, low))
            | back.simd_gt(splat(s, high));
        let bits = (lanes & beyond & x.simd_ne(y)).to_bitmask();
        for lane in (0..width::<S>()).filter(|lane| bits >> lane & 1 == 1) {
            let found = self.0.over_length(front[lane], back[lane], length[lane]);
            for (channel, value) in rgba.iter_mut().zip(found) {
                channel[lane] = value;
            }
        }
        rgba
    }

    /// Entries of full steps between limited positions over other lengths: those of the ends of rays. A function of its
    /// own, so that all others find the registers that they had without it.
    #[inline(never)]
    fn over<S: Lanes>(&self, s: S, rgba: [F32<S>; 4], [x, y]: [F32<S>; 2], length: F32<S>) -> [F32<S>; 4] {
        s.vectorize(
            #[inline(always)]
            || segment_over(s, rgba, self.bilinear(s, y, x), length),
        )
    }

    /// The entries of full steps between limited positions.
    #[inline(always)]
    fn bilinear<S: Lanes>(&self, s: S, x: F32<S>, y: F32<S>) -> [F32<S>; 4] {
        let row = self.0.nodes().count();
        let ((near, u), (far, v)) = (cell(s, x, row - 1), cell(s, y, row - 1));
        let corner = near + far * row as i32;
        let base = self.0.entries().as_ptr().cast::<f32>();
        // SAFETY: `cell` gives nodes from 0 to the last but one.
        let [c00, c10, c01, c11] = unsafe {
            [
                s.gather_rows::<2>(base, corner),
                s.gather_rows::<2>(base.add(4), corner),
                s.gather_rows::<2>(base.add(4 * row), corner),
                s.gather_rows::<2>(base.add(4 * row + 4), corner),
            ]
        };
        rgba!(C => lerp::<S>(v, lerp::<S>(u, c00[C], c10[C]), lerp::<S>(u, c01[C], c11[C])))
    }
}

/// Associated colours of segments over `ratio` times the length they hold for, by those of the same segments seen from
/// their other ends: the vectors' form of [`correct_segment`](pellucid_optics::correct_segment).
#[inline(always)]
fn segment_over<S: Lanes>(s: S, rgba: [F32<S>; 4], reversed: [F32<S>; 4], ratio: F32<S>) -> [F32<S>; 4] {
    let (half, one) = (splat(s, 0.5), splat(s, 1.0));
    let depth = extinction(s, rgba[3]);
    let thin = depth.simd_lt(splat(s, 1e-3));
    let whole = advance(s, thin.select(one, depth));
    let share = thin.select(half * (one - ratio), half * (one - advance(s, depth * ratio) / whole));
    let [r, g, b] = xyz!(C => share.mul_add(reversed[C] - rgba[C], rgba[C]));
    over_length(s, [r, g, b, rgba[3]], ratio)
}

/// How far in front of the middle the light of an optical depth comes from: the vectors' form of
/// [`advance`](pellucid_optics::advance).
#[inline(always)]
fn advance<S: Lanes>(s: S, depth: F32<S>) -> F32<S> {
    let (one, squared) = (splat(s, 1.0), depth * depth);
    let thin = depth.simd_lt(one);
    let series = squared.mul_add(splat(s, -1.0 / 1_209_600.0), splat(s, 1.0 / 30_240.0));
    let series = squared.mul_add(series, splat(s, -1.0 / 720.0));
    let series = depth * squared.mul_add(series, splat(s, 1.0 / 12.0));
    let safe = thin.select(one, depth);
    thin.select(series, one / opacity_of(s, safe) - one / safe - 0.5)
}

/// Associated colours over `ratio` times the length they hold for (1.4-14), a few times at most: the vectors'
/// form of [`correct_associated`](pellucid_optics::correct_associated). Where the ratio is 1 they
/// stay what they are, to the bit.
#[inline(always)]
pub fn over_length<S: Lanes>(s: S, rgba: [F32<S>; 4], ratio: F32<S>) -> [F32<S>; 4] {
    let [r, g, b, alpha] = rgba;
    let changed = ratio.simd_ne(splat(s, 1.0));
    let corrected = opacity_over(s, alpha, ratio);
    let thin = alpha.simd_lt(splat(s, f32::MIN_POSITIVE));
    let scale = thin.select(ratio, corrected / thin.select(splat(s, 1.0), alpha));
    let found = [r * scale, g * scale, b * scale, corrected];
    rgba!(C => changed.select(found[C], rgba[C]))
}
