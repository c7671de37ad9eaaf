//! Volume files in and out (NRRD, MetaImage, NIfTI, raw) and pictures (PNG, EXR).
