//! `pellucid info --adapters`.

use pellucid::gpu::{AdapterSummary, Capabilities, adapters};
use serde_json::{Value, json};

use super::failure::Failure;
use super::report::{print, print_json};

/// Prints all graphics adapters, the best first.
pub fn list(as_json: bool) -> Result<(), Failure> {
    let all = adapters();
    if as_json {
        return print_json(&Value::Array(all.iter().map(|(adapter, can)| object(adapter, can)).collect()));
    }
    if all.is_empty() {
        return print("no graphics adapters; on Debian mesa-vulkan-drivers brings one that runs on the processor\n");
    }
    all.iter().try_for_each(|(adapter, can)| print(&format!("{adapter}\n  {can}\n")))
}

fn object(adapter: &AdapterSummary, can: &Capabilities) -> Value {
    let features: serde_json::Map<String, Value> =
        can.optional().map(|(name, there)| (name.to_lowercase(), there.into())).collect();
    json!({
        "name": adapter.name,
        "kind": adapter.kind,
        "api": adapter.api,
        "driver": adapter.driver,
        "limits": {
            "texture_3d": can.limits.max_texture_dimension_3d,
            "buffer_bytes": can.limits.max_buffer_size,
            "binding_bytes": can.limits.max_storage_buffer_binding_size,
            "workgroup_invocations": can.limits.max_compute_invocations_per_workgroup,
        },
        "features": features,
    })
}
