//! Settings of the slicing family (chapter 3).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Technique;
use super::mode::{Mode, Slice};
use super::needs::{LightPath, Needs};
use super::settings::Settings;
use crate::check::{Checked, require};

/// Settings of the slicers. Slices keep no depth and no normals: blending forgets where light came from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Slicing {
    /// What becomes of the samples. Default composite. Slabs have some thickness.
    pub mode: Mode,
    /// Where the slices lie. Default view_aligned.
    pub geometry: SliceGeometry,
    /// The order in which slices are blended. Default front_to_back.
    pub order: BlendOrder,
    /// What slices are blended in (9.5). Default f32.
    pub target: SliceTarget,
    /// Whether colours carry their opacity when they are interpolated and blended. Default associated.
    pub colors: ColorWeight,
    /// How opacity follows the distance between slices. Default per_sample.
    pub correction: Correction,
    /// Who cuts the volume's box into slices. Default vertex_stage.
    pub proxy: Proxy,
    /// Samples that a slice stands for, 1 to 16 (4.6-6): more of them make fewer, thicker slices. Default 1.
    pub samples: u32,
    /// Slices between two looks at the pixels that are done, 0 to 1000 (8.6-2); 0 never looks. Front to back
    /// only. Default 10.
    pub termination_interval: u32,
    /// Whether blocks that are hidden behind what is drawn are left out (8.5). Default true.
    pub occlusion_culling: bool,
}

impl Default for Slicing {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            geometry: SliceGeometry::default(),
            order: BlendOrder::default(),
            target: SliceTarget::default(),
            colors: ColorWeight::default(),
            correction: Correction::default(),
            proxy: Proxy::default(),
            samples: 1,
            termination_interval: 10,
            occlusion_culling: true,
        }
    }
}

/// Where slices lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SliceGeometry {
    /// Across the view, a step apart, through the 3D texture (3.3).
    #[default]
    ViewAligned,
    /// The volume's own planes of voxels, along the axis that is nearest to the view, as 2D textures (3.2).
    ObjectAligned,
    /// Across that axis, at any distance: between two 2D textures each (3.4).
    MultiTexture,
    /// Spheres around the eye, a step apart (3.6-1).
    Shells,
}

/// The order of blending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BlendOrder {
    /// The nearest first: what is hidden need not be drawn (3.2-7).
    #[default]
    FrontToBack,
    /// The farthest first (3.2-5).
    BackToFront,
}

/// Numbers that slices are blended in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SliceTarget {
    /// 8 bits a channel, 0 to 1: thin samples are lost.
    U8,
    /// Half precision.
    F16,
    /// Single precision.
    #[default]
    F32,
}

/// Whether colours are multiplied by their opacity before they are mixed (3.2-8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ColorWeight {
    /// They are: what cannot be seen has no colour.
    #[default]
    Associated,
    /// They are not: colours of invisible voxels bleed into pre-classified pictures (3.2-6).
    NonAssociated,
}

/// How opacity follows the distance between slices along a ray (3.2-12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Correction {
    /// Exactly, for every sample.
    #[default]
    PerSample,
    /// As in the middle of the picture.
    PerFrame,
    /// As if every ray crossed the slices at a right angle.
    Off,
}

/// Who cuts the volume's box into slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Proxy {
    /// The vertex stage, for all boxes and slices at once (3.5).
    #[default]
    VertexStage,
    /// The processor, once a frame (3.3-2).
    Processor,
}

impl Settings for Slicing {
    fn name(&self) -> &'static str {
        "slicing"
    }

    /// Blending units hold all colours back alike, and look at no light. Slices through several volumes are composited
    /// as they are drawn, and lie along the axes of none; values are projected volume by volume.
    fn needs(&self) -> Needs {
        let through_all = matches!(self.geometry, SliceGeometry::ViewAligned | SliceGeometry::Shells);
        let meets_surfaces = matches!(self.mode, Mode::Isosurface(_));
        let several = through_all || !(meets_surfaces || self.mode == Mode::Composite);
        Needs {
            light: LightPath::Arrives,
            ambient: true,
            classification: self.mode == Mode::Composite,
            extinction_color: false,
            shadows: false,
            several_volumes: several,
            overlap: several && !meets_surfaces,
            data_colors: false,
            adaptive: false,
            jitter: self.geometry != SliceGeometry::ObjectAligned,
            front_to_back: self.order == BlendOrder::FrontToBack,
            blending: true,
            frames: 1,
        }
    }

    fn mode(&self) -> &Mode {
        &self.mode
    }

    fn mode_mut(&mut self) -> Option<&mut Mode> {
        Some(&mut self.mode)
    }

    fn plain(&self) -> Technique {
        Technique::Slicing(Self { mode: self.mode.plain(), geometry: self.geometry, ..Self::default() })
    }

    fn check(&self, path: &str) -> Checked {
        if let Mode::Slice(Slice { thickness, .. }) = self.mode {
            let expected = "a length above 0: a plane is for the ray caster";
            require(thickness > 0.0, &format!("{path}.mode.slice"), "thickness", thickness, expected)?;
        }
        require((1..=16).contains(&self.samples), path, "samples", self.samples, "1 to 16")?;
        let interval = self.termination_interval;
        require(interval <= 1000, path, "termination_interval", interval, "0 to 1000 slices")
    }
}
