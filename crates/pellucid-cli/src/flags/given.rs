//! Which flags were given, and where the settings they change stand in the document.

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, FromArgMatches};
use pellucid::WithoutEffect;

/// Flags and the settings they change, of those that may have no effect.
const SETTINGS: [(&str, &str); 29] = [
    ("zoom", "camera.view.orbit.zoom"),
    ("distance", "camera.view.orbit.distance"),
    ("preset", "volumes[0].preset"),
    ("window", "volumes[0].window"),
    ("colormap", "volumes[0].colormap"),
    ("colors", "volumes[0].colors"),
    ("opacity", "volumes[0].opacity"),
    ("unit_distance", "volumes[0].unit_distance"),
    ("transfer_function", "volumes[0].transfer_function"),
    ("shading", "volumes[0].shading"),
    ("ambient", "volumes[0].material"),
    ("diffuse", "volumes[0].material"),
    ("specular", "volumes[0].material"),
    ("shininess", "volumes[0].material"),
    ("light", "lighting.lights"),
    ("combine", "technique.ray_cast.mode.slice.combine"),
    ("combine", "technique.slicing.mode.slice.combine"),
    ("step", "quality.step"),
    ("gradient", "quality.gradient"),
    ("classification", "quality.classification"),
    ("jitter", "quality.jitter"),
    ("early_termination", "quality.early_termination"),
    ("adaptive", "quality.adaptive_tolerance"),
    ("supersampling", "quality.supersampling"),
    ("filter", "quality.filter"),
    ("azimuth", "camera.view.orbit.azimuth"),
    ("elevation", "camera.view.orbit.elevation"),
    ("roll", "camera.view.orbit.roll"),
    ("target", "camera.view.orbit.target"),
];

/// The names of the flags on the command line, as clap knows them.
#[derive(Clone, Debug, Default)]
pub struct Given(Vec<String>);

impl Given {
    /// The settings that flags have set, to whatever value.
    pub fn settings(&self) -> Vec<&'static str> {
        SETTINGS
            .iter()
            .filter(|(flag, _)| self.0.iter().any(|given| given == flag))
            .map(|(_, setting)| *setting)
            .collect()
    }

    /// A setting without effect, called by the flags that set it if there are such.
    pub fn in_words(&self, idle: &WithoutEffect) -> String {
        let sets = |setting: &str| {
            setting.strip_prefix(&*idle.setting).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        };
        let given = |flag: &str| self.0.iter().any(|given| given == flag);
        let flags = SETTINGS.iter().filter(|(flag, setting)| given(flag) && sets(setting));
        let flags: Vec<String> = flags.map(|(flag, _)| format!("--{}", flag.replace('_', "-"))).collect();
        match flags.as_slice() {
            [] => idle.to_string(),
            [flag] => format!("{flag} has no effect: {}", idle.reason),
            flags => format!("{} have no effect: {}", flags.join(" and "), idle.reason),
        }
    }
}

impl FromArgMatches for Given {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let by_user = |id: &&clap::Id| matches.value_source(id.as_str()) == Some(ValueSource::CommandLine);
        Ok(Self(matches.ids().filter(by_user).map(ToString::to_string).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// It takes no flags of its own: it looks at those of its neighbours.
impl Args for Given {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}
