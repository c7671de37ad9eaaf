//! NIfTI headers put together field by field, at the offsets that nifti1.h and nifti2.h list.

/// Numbers of one header, in one byte order.
pub struct Header {
    pub bytes: Vec<u8>,
    big: bool,
    version: u8,
}

impl Header {
    /// A single file of 2 x 3 x 2 `i16` voxels of 1 mm, with neither q-form nor s-form.
    pub fn new(version: u8, big: bool) -> Self {
        let (size, offset) = if version == 1 { (348, 352.0) } else { (540, 544.0) };
        let mut header = Self { bytes: vec![0; offset as usize], big, version };
        header.i32(0, size);
        if version == 1 {
            header.bytes[344..348].copy_from_slice(b"n+1\0");
        } else {
            header.bytes[4..12].copy_from_slice(b"n+2\0\r\n\x1a\n");
        }
        header.dim(&[3, 2, 3, 2, 1, 1, 1, 1]).datatype(4, 16).pixdim(&[1.0; 8]).vox_offset(offset).units(2)
    }

    pub fn raw(&mut self, at: usize, little: &[u8]) {
        let mut bytes = little.to_vec();
        if self.big {
            bytes.reverse();
        }
        self.bytes[at..at + bytes.len()].copy_from_slice(&bytes);
    }
    fn i16(&mut self, at: usize, value: i16) {
        self.raw(at, &value.to_le_bytes());
    }
    fn i32(&mut self, at: usize, value: i32) {
        self.raw(at, &value.to_le_bytes());
    }
    /// A real number: single in the first version, double in the second.
    fn real(&mut self, at: [usize; 2], index: usize, value: f64) {
        match self.version {
            1 => self.raw(at[0] + 4 * index, &(value as f32).to_le_bytes()),
            _ => self.raw(at[1] + 8 * index, &value.to_le_bytes()),
        }
    }

    pub fn dim(mut self, dim: &[i64]) -> Self {
        for (k, &n) in dim.iter().enumerate() {
            match self.version {
                1 => self.i16(40 + 2 * k, n as i16),
                _ => self.raw(16 + 8 * k, &n.to_le_bytes()),
            }
        }
        self
    }
    pub fn datatype(mut self, code: i16, bits: i16) -> Self {
        let at = if self.version == 1 { 70 } else { 12 };
        self.i16(at, code);
        self.i16(at + 2, bits);
        self
    }
    pub fn pixdim(mut self, pixdim: &[f64]) -> Self {
        pixdim.iter().enumerate().for_each(|(k, &size)| self.real([76, 104], k, size));
        self
    }
    pub fn vox_offset(mut self, offset: f64) -> Self {
        match self.version {
            1 => self.real([108, 0], 0, offset),
            _ => self.raw(168, &(offset as i64).to_le_bytes()),
        }
        self
    }
    pub fn slope(mut self, slope: f64, inter: f64) -> Self {
        self.real([112, 176], 0, slope);
        self.real([116, 184], 0, inter);
        self
    }
    pub fn units(mut self, code: u8) -> Self {
        match self.version {
            1 => self.bytes[123] = code,
            _ => self.i32(500, code.into()),
        }
        self
    }
    pub fn qform(mut self, code: i16, quatern: [f64; 3], offset: [f64; 3]) -> Self {
        match self.version {
            1 => self.i16(252, code),
            _ => self.i32(344, code.into()),
        }
        quatern.iter().chain(&offset).enumerate().for_each(|(k, &part)| self.real([256, 352], k, part));
        self
    }
    pub fn sform(mut self, code: i16, rows: [[f64; 4]; 3]) -> Self {
        match self.version {
            1 => self.i16(254, code),
            _ => self.i32(348, code.into()),
        }
        rows.iter().flatten().enumerate().for_each(|(k, &part)| self.real([280, 400], k, part));
        self
    }
    /// The whole file with `i16` values 0, 1, 2, ... of its byte order.
    pub fn with_counting(&self, count: i16) -> Vec<u8> {
        let order = |value: i16| if self.big { value.to_be_bytes() } else { value.to_le_bytes() };
        self.bytes.iter().copied().chain((0..count).flat_map(order)).collect()
    }
    pub fn with(&self, data: &[u8]) -> Vec<u8> {
        [&self.bytes, data].concat()
    }
}
