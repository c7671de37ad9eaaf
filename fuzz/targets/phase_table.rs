#![no_main]

use libfuzzer_sys::fuzz_target;
use pellucid_optics::{Phase, PhaseEntries, PhaseTable, TableAngles};

fuzz_target!(|text: &str| {
    let Ok(entries) = PhaseEntries::from_text(text) else { return };
    let Ok(table) = PhaseTable::of_file(TableAngles::Theta, "fuzz.csv") else { return };
    let mut phase = Phase::Table(table);
    if phase.fill(&entries).is_ok() {
        assert!(phase.eval(0.0, 0.3).iter().all(|value| *value >= 0.0));
    }
});
