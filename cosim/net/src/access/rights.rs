//! Queries the listening side for the rights of a name. Zenoh's access control drops what it denies
//! silently; this query explains it. The answer is for users only: nothing depends on it.

use std::sync::mpsc::channel;
use std::time::Duration;

use zenoh::{Session, Wait};

use super::members::{Members, Role};
use super::session::Access;
use crate::keys;
use cosim_base::error::{Code, Error, Result};

/// How long to wait for the other side; one without a list of members does not answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// Answers rights queries.
pub(crate) fn answer(session: &Session, members: Members) -> Result<()> {
    session
        .declare_queryable(keys::rights())
        .callback(move |query| {
            let name = query.payload().map(|name| name.to_bytes().into_owned()).unwrap_or_default();
            let role = members.role(&String::from_utf8_lossy(&name));
            let text = postcard::to_stdvec(&role).unwrap_or_default();
            // A client that has disconnected needs no answer.
            let _ = query.reply(query.key_expr().clone(), text).wait();
        })
        .background()
        .wait()
        .map_err(|why| Error::new(Code::Session, "the session failed").why(why))
}

/// Fails if the other side is known to forbid what a `wanted` role does. Returns the name in our
/// certificate and its role, if the other side keeps rights.
pub(crate) fn ask(
    session: &Session,
    access: &Access,
    wanted: Role,
) -> Result<Option<(String, Role)>> {
    let Some(name) = access.common_name() else {
        return Ok(None);
    };
    let (answers, inbox) = channel();
    session
        .get(keys::rights())
        .payload(name.clone())
        .timeout(PATIENCE)
        .callback(move |reply| {
            if let Ok(sample) = reply.result() {
                let role = postcard::from_bytes::<Option<Role>>(&sample.payload().to_bytes());
                let _ = answers.send(role.ok());
            }
        })
        .wait()
        .map_err(|why| Error::new(Code::Session, "the session failed").why(why))?;
    let Ok(Some(role)) = inbox.recv() else {
        return Ok(None);
    };
    let is = match role {
        Some(role) if role == wanted || role == Role::Orchestrator => {
            return Ok(Some((name, role)));
        }
        Some(role) => format!("it knows that name as {}", role.text()),
        None => "it does not know that name".to_owned(),
    };
    let what = format!("the other side does not accept '{name}' as {}", wanted.text());
    Err(Error::new(Code::Forbidden, what)
        .why(format!("'{name}' is the name in our certificate, and {is}"))
        .help("members.json in the folder of the other side's certificate says who may do what"))
}
