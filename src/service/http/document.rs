//! What the OpenAPI document says beside the routes.

use crate::service::problem::{PROBLEM_JSON, ProblemDocument};
use utoipa::openapi::path::{Operation, PathItem};
use utoipa::openapi::{Content, OpenApi, Ref, RefOr, Response};
use utoipa::{OpenApi as _, ToSchema};

#[derive(utoipa::OpenApi)]
#[openapi(
    info(
        title = "Topostar",
        description = "Turns what a robot saw at places and did between them into the topological map that \
                       explains it best, and keeps every rival map that is still possible. Every error is a \
                       problem document of RFC 9457.",
        license(name = "MIT OR Apache-2.0", identifier = "MIT OR Apache-2.0"),
        contact()
    ),
    tags(
        (name = "maps", description = "Maps and what explains them."),
        (name = "reasons", description = "Why maps were refuted, what sets candidates apart, where to look next."),
        (name = "events", description = "What robots saw and did."),
        (name = "jobs", description = "Work that a client does not wait for."),
        (name = "process", description = "The service itself.")
    ),
    components(schemas(ProblemDocument))
)]
struct Head;

/// The document before its routes.
pub(super) fn head() -> OpenApi {
    Head::openapi()
}

/// The document with the body that the edge gives every error, which routes therefore leave out.
pub(super) fn with_problems(mut document: OpenApi) -> OpenApi {
    let operations = document.paths.paths.values_mut().flat_map(operations);
    for operation in operations {
        let responses = &mut operation.responses.responses;
        for (status, response) in responses {
            if let RefOr::T(response) = response
                && status.starts_with(['4', '5'])
            {
                describe_problem(response);
            }
        }
    }
    document
}

fn operations(item: &mut PathItem) -> impl Iterator<Item = &mut Operation> {
    [&mut item.get, &mut item.put, &mut item.post, &mut item.delete].into_iter().flatten()
}

fn describe_problem(response: &mut Response) {
    let problem = Content::new(Some(Ref::from_schema_name(ProblemDocument::name())));
    response.content.insert(PROBLEM_JSON.to_owned(), problem.into());
}
