//! What the figures were taken on.

use std::num::NonZero;

use serde_json::{Value, json};

/// Notes that belong beside every figure.
pub struct Machine {
    /// The processor's name, where the system tells.
    pub cpu: Option<String>,
    /// Cores this process may use.
    pub cores: usize,
}

impl Machine {
    /// This machine.
    pub fn new() -> Self {
        let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        Self { cpu: model(&told), cores: std::thread::available_parallelism().map_or(1, NonZero::get) }
    }

    /// One line.
    pub fn text(&self) -> String {
        let cpu = self.cpu.as_deref().unwrap_or("unknown processor");
        let [version, os, arch] = notes();
        format!("pellucid {version} on {cpu}, {} cores, {os} {arch}", self.cores)
    }

    /// The same as JSON.
    pub fn json(&self) -> Value {
        let [version, os, arch] = notes();
        json!({ "cpu": self.cpu, "cores": self.cores, "os": os, "arch": arch, "pellucid": version })
    }
}

/// Version of the program, operating system and architecture.
fn notes() -> [&'static str; 3] {
    [env!("CARGO_PKG_VERSION"), std::env::consts::OS, std::env::consts::ARCH]
}

/// The first model name in the text of `/proc/cpuinfo`.
fn model(told: &str) -> Option<String> {
    let line = told.lines().find(|line| line.starts_with("model name"))?;
    line.split_once(':').map(|(_, name)| name.trim().to_owned())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_model_name_is_what_follows_the_colon() {
        let told = "processor\t: 0\nmodel\t\t: 2\nmodel name\t: AMD EPYC: 9\nflags\t: fpu\nmodel name\t: other\n";
        assert_eq!(super::model(told).as_deref(), Some("AMD EPYC: 9"));
        assert_eq!(super::model("Processor : ARM"), None);
    }
}
