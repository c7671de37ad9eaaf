//! The control colours of the maps.
//!
//! Sources: viridis, plasma, inferno, magma (van der Walt and Smith 2015, CC0), cividis (Nunez,
//! Anderton and Renslow 2018), turbo (Mikhailov 2019), coolwarm (Moreland 2009), gray, bone, hot
//! (the classical maps) and tab10 (Tableau), all as matplotlib 3.11 publishes them. Each is
//! reduced to the few of its 256 colours between which straight lines stay closest to all of
//! them; the largest distance, in 8-bit code values of a channel, is noted with each.

use super::ColorMap;

/// All maps, in the order they are offered: position of 255 and `0xrrggbb`.
#[rustfmt::skip]
pub(super) const MAPS: &[ColorMap] = &[
    // Blue, green, yellow; perceptually uniform; within 0.5 of 255.
    ColorMap {
        name: "viridis",
        nodes: &[
            (0, 0x440154), (14, 0x481668), (29, 0x482979), (44, 0x443b84), (62, 0x3c508b), (88, 0x2f6b8e),
            (120, 0x23898e), (139, 0x1e9b8a), (149, 0x20a486), (159, 0x27ad81), (168, 0x32b67a), (177, 0x40bd72),
            (188, 0x56c667), (197, 0x69cd5b), (208, 0x84d44b), (223, 0xaadc32), (234, 0xc8e020), (240, 0xd8e219),
            (244, 0xe2e418), (247, 0xeae51a), (251, 0xf4e61e), (255, 0xfde725),
        ],
        categorical: false,
        reversed: false,
    },
    // Blue, red, yellow; perceptually uniform; within 0.49 of 255.
    ColorMap {
        name: "plasma",
        nodes: &[
            (0, 0x0d0887), (4, 0x19068c), (14, 0x2e0595), (33, 0x4e02a2), (50, 0x6900a8), (62, 0x7b02a8),
            (70, 0x8707a6), (81, 0x9613a1), (94, 0xa72197), (114, 0xbe3885), (138, 0xd5536f), (167, 0xeb7556),
            (188, 0xf79044), (207, 0xfdab33), (221, 0xfec029), (233, 0xfbd324), (245, 0xf6e826), (251, 0xf2f227),
            (254, 0xf0f724), (255, 0xf0f921),
        ],
        categorical: false,
        reversed: false,
    },
    // Black, red, pale yellow; perceptually uniform; within 0.8 of 255.
    ColorMap {
        name: "inferno",
        nodes: &[
            (0, 0x000004), (3, 0x010108), (12, 0x07051b), (22, 0x120a32), (31, 0x1f0c48), (40, 0x2f0a5b),
            (50, 0x400a67), (61, 0x520e6d), (77, 0x6c186e), (94, 0x87216b), (117, 0xab2f5e), (137, 0xc83f4b),
            (155, 0xdf5337), (172, 0xef6c23), (190, 0xf98b0b), (196, 0xfb9606), (201, 0xfc9f07), (206, 0xfca80d),
            (217, 0xfbbe23), (227, 0xf7d13d), (235, 0xf4e156), (244, 0xf1f179), (251, 0xf6fa96), (255, 0xfcffa4),
        ],
        categorical: false,
        reversed: false,
    },
    // Black, purple, cream; perceptually uniform; within 0.5 of 255.
    ColorMap {
        name: "magma",
        nodes: &[
            (0, 0x000004), (2, 0x010106), (6, 0x02020d), (16, 0x0a0822), (29, 0x19103f), (39, 0x271258),
            (48, 0x36106b), (55, 0x420f75), (64, 0x51127c), (80, 0x6a1c81), (94, 0x802582), (114, 0xa02f7f),
            (133, 0xbf3a77), (145, 0xd2426f), (154, 0xdf4a68), (164, 0xeb5760), (174, 0xf4675c), (182, 0xf8765c),
            (193, 0xfc8a62), (206, 0xfea36f), (224, 0xfec488), (245, 0xfdebac), (255, 0xfcfdbf),
        ],
        categorical: false,
        reversed: false,
    },
    // Blue to yellow, nearly alike with colour-deficient vision; within 0.5 of 255.
    ColorMap {
        name: "cividis",
        nodes: &[
            (0, 0x00224e), (12, 0x002b62), (19, 0x00306f), (22, 0x003171), (23, 0x013271), (27, 0x0f3570),
            (30, 0x163770), (35, 0x203a6f), (47, 0x31436d), (64, 0x434e6c), (82, 0x555b6d), (110, 0x6d6f72),
            (127, 0x7c7b78), (138, 0x868379), (167, 0xa29975), (193, 0xbdae6c), (215, 0xd4c15f), (232, 0xe7d150),
            (244, 0xf5dc41), (250, 0xfce236), (251, 0xfde334), (252, 0xfee434), (254, 0xfee636), (255, 0xfee838),
        ],
        categorical: false,
        reversed: false,
    },
    // A rainbow without its false edges; within 1.59 of 255.
    ColorMap {
        name: "turbo",
        nodes: &[
            (0, 0x30123b), (8, 0x392a73), (17, 0x4143a7), (27, 0x455ed3), (36, 0x4776ee), (44, 0x458afc),
            (51, 0x3e9bfe), (60, 0x2fb2f4), (74, 0x1ad2d2), (82, 0x18e0bd), (90, 0x22ebaa), (100, 0x3ff68a),
            (117, 0x80ff53), (126, 0x9ffd3f), (135, 0xb7f735), (148, 0xd7e535), (164, 0xf4c73a), (176, 0xfdac34),
            (190, 0xfc8423), (205, 0xef5811), (219, 0xda3907), (237, 0xb21a01), (254, 0x7e0502), (255, 0x7a0403),
        ],
        categorical: false,
        reversed: false,
    },
    // Blue, grey, red: deviations to either side of a middle; within 0.48 of 255.
    ColorMap {
        name: "coolwarm",
        nodes: &[
            (0, 0x3b4cc0), (14, 0x4b64d5), (29, 0x5e7de7), (42, 0x6f92f3), (57, 0x84a7fc), (71, 0x97b8ff),
            (83, 0xa7c5fe), (96, 0xb9d0f9), (110, 0xcad8ef), (123, 0xd8dce2), (127, 0xdcdddd), (141, 0xead5c9),
            (154, 0xf2cab5), (167, 0xf7bca1), (183, 0xf7a688), (196, 0xf29274), (208, 0xeb7d62), (223, 0xde614d),
            (239, 0xcb3e38), (247, 0xc0282f), (255, 0xb40426),
        ],
        categorical: false,
        reversed: false,
    },
    // Black to white; within 0.0 of 255.
    ColorMap {
        name: "gray",
        nodes: &[
            (0, 0x000000), (255, 0xffffff),
        ],
        categorical: false,
        reversed: false,
    },
    // Black to white by way of blue, like an X-ray film; within 0.5 of 255.
    ColorMap {
        name: "bone",
        nodes: &[
            (0, 0x000000), (93, 0x515171), (191, 0xa7c7c7), (255, 0xffffff),
        ],
        categorical: false,
        reversed: false,
    },
    // Black, red, yellow, white; within 0.39 of 255.
    ColorMap {
        name: "hot",
        nodes: &[
            (0, 0x0b0000), (93, 0xff0000), (190, 0xfffe00), (191, 0xffff03), (255, 0xffffff),
        ],
        categorical: false,
        reversed: false,
    },
    // Ten colours for categories; exact.
    ColorMap {
        name: "tab10",
        nodes: &[
            (0, 0x1f77b4), (1, 0xff7f0e), (2, 0x2ca02c), (3, 0xd62728), (4, 0x9467bd),
            (5, 0x8c564b), (6, 0xe377c2), (7, 0x7f7f7f), (8, 0xbcbd22), (9, 0x17becf),
        ],
        categorical: true,
        reversed: false,
    },
];
